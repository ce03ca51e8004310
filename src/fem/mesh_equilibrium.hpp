// The equilibrium of a mesh of elements between its supports, contacts and loads: the potential energy of a
// displacement, what is out of balance there, and the step that Newton's method takes. Internal.
#pragma once

#include <Eigen/SparseCholesky>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "fem/element_model.hpp"

namespace turgor::detail {

/// A displacement and what it does, under a part of the load.
struct MeshState {
  std::vector<Vec3> displacement_mm;
  ElementState elements;
  double potential_nmm = 0;    ///< of elements and contacts, less the work of the loads
  double size_nmm = 0;         ///< sum of the sizes of its terms, by which it is rounded
  Eigen::VectorXd unbalanced;  ///< loads and contacts less inner forces, of the unknowns, N
  double carried_n = 0;        ///< norm of the loads, or of the reactions, if that is larger

  [[nodiscard]] bool valid() const { return elements.valid(); }
};

class MeshEquilibrium {
 public:
  /// All must outlive it and be checked.
  MeshEquilibrium(const ElementMesh& mesh, const ElementModel& model, const ElasticSupports& supports,
                  std::span<const Vec3> load_n);

  /// What is held displaced by a part of what is prescribed, the rest as it was.
  [[nodiscard]] std::vector<Vec3> with_prescribed(std::vector<Vec3> displacement_mm, double part) const;
  [[nodiscard]] std::vector<Vec3> moved(std::vector<Vec3> displacement_mm, const Eigen::VectorXd& step,
                                        double factor) const;
  /// Whether it takes a point beyond a thousand times the size of the body and of what is prescribed, where
  /// nothing holds it and rounding hides its forces.
  [[nodiscard]] bool carried_off(const std::vector<Vec3>& displacement_mm) const;
  /// Under a part of the load.
  [[nodiscard]] MeshState evaluate(std::vector<Vec3> displacement_mm, double part) const;

  enum class Tangent : std::uint8_t { exact, definite };
  struct Step {
    Eigen::VectorXd step;   ///< of the unknowns
    Eigen::VectorXd right;  ///< the forces that it balances
    bool stable = true;     ///< K is positive definite
  };
  /// K step = unbalanced − K moves, where `moves` is of what is held (empty: none). `definite`: K without
  /// negative curvatures, stiffened until it is positive definite. None where K cannot be factored.
  std::optional<Step> newton_step(const MeshState& state, std::span<const Vec3> moves, Tangent tangent);

  /// What supports and contacts do to each node.
  [[nodiscard]] std::vector<Vec3> reactions(const MeshState& state, double part) const;

 private:
  using Matrix = Eigen::SparseMatrix<double>;
  [[nodiscard]] int number(int point, int component) const;
  [[nodiscard]] Matrix stiffness(const MeshState& state, bool definite, std::span<const Vec3> moves,
                                 Eigen::VectorXd& right) const;
  bool factor(const Matrix& matrix);
  [[nodiscard]] bool positive() const;

  const ElementMesh& mesh_;
  const ElementModel& model_;
  std::span<const Contact> contacts_;
  std::span<const Vec3> load_n_;
  std::vector<int> number_;  // of the unknown of each component; −1: held, −2: of a point of no element
  std::vector<Vec3> prescribed_;
  int unknowns_ = 0;
  double farthest_mm_ = 0;
  bool analyzed_ = false;
  Eigen::SimplicialLDLT<Matrix> factors_;
};

}  // namespace turgor::detail
