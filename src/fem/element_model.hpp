// Energy, forces and stiffness of a mesh of elements, whose θ (fem/elastic_material.hpp) is a mean over
// patches: a hexahedron is a patch; prisms and tetrahedra give an equal share of theirs to the patch of their
// material around each of their points (Bonet and Burton 1998, "A simple average nodal pressure tetrahedral
// element"). A patch of volume V and bulk modulus K, the mean of what its shares are of, has ½ K V θ̄².
// Internal.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

#include "fem/element_shapes.hpp"
#include "fem/law_response.hpp"
#include "turgor/fem/mesh_elasticity.hpp"

namespace turgor::detail {

/// Corners of element `e` in the mesh's numbering.
std::span<const int> corners_of(const ElementMesh& mesh, std::size_t e);

/// What one displacement does to the elements. Not `valid`: some have no energy; forces say nothing then.
struct ElementState {
  std::size_t turned_over = 0;  ///< elements that have no energy
  std::size_t first_turned_over = 0;
  double energy_nmm = 0;
  std::vector<Vec3> force_n;         ///< gradient of the energy
  double rounding_n = 0;             ///< size of the error of the forces by rounding displacements
  std::vector<LawResponse> point;    ///< of each Gauss point
  std::vector<double> pressure_mpa;  ///< of each element: the stress beside θ

  [[nodiscard]] bool valid() const { return turned_over == 0; }
};

Error turned_over(std::size_t element);

class ElementModel {
 public:
  /// Errors: those of the mesh and the body in fem/mesh_elasticity.hpp.
  static Result<ElementModel> prepare(const ElementMesh& mesh, const ElasticBody& body);

  [[nodiscard]] ElementState evaluate(std::span<const Vec3> displacement_mm) const;
  /// Calls add(a, b, K_ab) for pairs of points, several times for some; K_ab are blocks of the second
  /// derivative of the energy, `definite`: of what is left of it without negative curvatures at Gauss points.
  using AddBlock = std::function<void(int a, int b, const Eigen::Matrix3d& block)>;
  void add_stiffness(std::span<const Vec3> displacement_mm, const ElementState& state, bool definite,
                     const AddBlock& add) const;
  /// Means over elements, by their volume at rest, of the Cauchy stress and the law's strain. Of a valid
  /// state. Error: an element is turned over, by a law that lets it.
  [[nodiscard]] Result<std::vector<ElementStress>> stress(std::span<const Vec3> displacement_mm,
                                                          const ElementState& state) const;
  /// Adds the weight of the elements.
  void add_gravity(const Vec3& acceleration, std::vector<Vec3>& force_n) const;
  /// Whether all laws are linear.
  [[nodiscard]] bool linear() const;
  [[nodiscard]] std::size_t points() const { return point_count_; }
  [[nodiscard]] std::span<const int> corners(std::size_t e) const { return elements_[e].nodes(); }

 private:
  struct Element {
    std::array<int, 8> corner{};
    std::size_t corners = 0, first = 0, count = 0;  // Gauss points first, first + 1, …
    std::array<int, 8> patch{};
    std::size_t patches = 0;
    double volume = 0;
    ElasticMaterial material;
    [[nodiscard]] std::span<const int> nodes() const { return {corner.data(), corners}; }
    [[nodiscard]] double share() const { return 1 / static_cast<double>(patches); }
  };
  struct Patch {
    double volume = 0, stiffness = 0;  // mm³, and K V in N·mm
    std::vector<int> elements, nodes;  // nodes rise
  };
  using ElementMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 24, 24>;

  void make_patches(const ElementMesh& mesh, const ElasticBody& body);
  [[nodiscard]] Tensor<double> gradient(const Element& e, std::size_t g, std::span<const Vec3> u) const;
  void add_forces(const Element& e, std::span<const Vec3> u, double pressure, ElementState& state) const;
  // False where the element is turned over.
  bool stress_of(std::size_t e, std::span<const Vec3> displacement_mm, const ElementState& state,
                 ElementStress& out) const;
  [[nodiscard]] ElementMatrix stiffness(const Element& e, std::span<const Vec3> u, double pressure,
                                        bool definite) const;
  void add_patch(const Patch& patch, const ElementState& state, const AddBlock& add) const;

  std::size_t point_count_ = 0;
  std::vector<GaussPoint> gauss_;
  std::vector<Element> elements_;
  std::vector<Patch> patches_;
};

}  // namespace turgor::detail
