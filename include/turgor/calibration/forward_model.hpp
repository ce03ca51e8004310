// What calibration knows of a model: parameters go in, positions and forces come out.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/math/vec.hpp"

namespace turgor {

/// One number that is fitted.
struct FitParameter {
  std::string name;          ///< as the report shows it: "k_d at node (0, 2, 1)"
  std::string unit;          ///< "MPa"
  double low = 0, high = 1;  ///< low < high; above 0 where logarithmic
  double guess = 0;          ///< before calibration, within the bounds
  bool logarithmic = true;   ///< searched by its logarithm
};

/// What is compared under one load: places in mm, and components of measured forces in N (or none). Always of
/// the same lengths for one load.
struct Response {
  std::vector<Vec3> position_mm;
  std::vector<double> force_n;

  /// Rows of a Jacobian: component k of position i is row 3 i + k, then come the forces.
  [[nodiscard]] std::size_t rows() const { return 3 * position_mm.size() + force_n.size(); }
};

/// By columns: value (row, column) at values[column · rows + row].
struct DenseMatrix {
  std::size_t rows = 0, columns = 0;
  std::vector<double> values;
};

/// A body at rest under one load, with one set of parameters.
class ForwardRun {
 public:
  virtual ~ForwardRun() = default;
  [[nodiscard]] virtual const Response& response() const = 0;
  /// ∂ response / ∂ parameters, exact.
  [[nodiscard]] virtual Result<DenseMatrix> jacobian(Context& context) const = 0;
  /// jacobianᵀ · `seed` (of the length rows()) by the adjoint method: one linear system, however many
  /// parameters there are.
  [[nodiscard]] virtual Result<std::vector<double>> adjoint(std::span<const double> seed,
                                                            Context& context) const = 0;
};

/// Every member may be called from several threads at once; the same call gives the same bits.
class ForwardModel {
 public:
  virtual ~ForwardModel() = default;
  [[nodiscard]] virtual std::size_t parameter_count() const = 0;
  [[nodiscard]] virtual std::size_t load_count() const = 0;
  /// The response at rest. `near`: of a run of the same load with parameters nearby, or null: where to begin
  /// from; without it the answer depends on the parameters alone. Errors: the body does not come to rest
  /// (ErrorKind::not_converged); cancelled; parameters that cannot be used.
  [[nodiscard]] virtual Result<std::unique_ptr<ForwardRun>> run(std::span<const double> parameters,
                                                                std::size_t load, const ForwardRun* near,
                                                                Context& context) const = 0;
};

}  // namespace turgor
