#include "turgor/fem/hexahedral_elasticity.hpp"

#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "fem/elastic_problem.hpp"
#include "fem/hexahedron.hpp"
#include "fem/rigid_pieces.hpp"
#include "turgor/core/index.hpp"

namespace turgor {
namespace {

using detail::HexPoint;

std::array<Vec3, 8> of_corners(std::span<const Vec3> values, const std::array<int, 8>& element) {
  std::array<Vec3, 8> out;
  for (std::size_t n = 0; n < 8; ++n) out[n] = values[at(element[n])];
  return out;
}

Result<void> check(const HexahedralMesh& mesh) {
  if (mesh.elements.empty() || mesh.points.size() > 100'000'000)
    return detail::bad_elasticity(
        fmt::format("there are {} elements over {} points", mesh.elements.size(), mesh.points.size()),
        "hexahedra", "Give a mesh of thousands of elements");
  for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
    const std::string where = fmt::format("hexahedron {}", e);
    for (const int p : mesh.elements[e]) {
      if (p < 0 || at(p) >= mesh.points.size())
        return detail::bad_elasticity(fmt::format("there is no point {}", p), where, "Repair the mesh");
    }
    for (const HexPoint& g : detail::gauss_points(of_corners(mesh.points, mesh.elements[e]))) {
      if (!(g.volume > 0) || !std::isfinite(g.volume))
        return detail::bad_elasticity("the element is turned over or has no volume", where,
                                      "Repair the mesh");
    }
  }
  return {};
}

// Faces as sorted corners, with the element behind each.
void face_pairs(const HexahedralMesh& mesh, const std::function<void(int, int)>& pair) {
  constexpr int faces[6][4] = {{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 5, 4},
                               {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  std::vector<std::pair<std::array<int, 4>, int>> all;
  for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
    for (const auto& face : faces) {
      std::array<int, 4> key{};
      for (std::size_t n = 0; n < 4; ++n) key[n] = mesh.elements[e][at(face[n])];
      std::sort(key.begin(), key.end());
      all.emplace_back(key, static_cast<int>(e));
    }
  }
  std::sort(all.begin(), all.end());
  for (std::size_t f = 1; f < all.size(); ++f)
    if (all[f].first == all[f - 1].first) pair(all[f - 1].second, all[f].second);
}

std::vector<double> flat(std::span<const Vec3> v) {
  std::vector<double> out;
  for (const Vec3& p : v) out.insert(out.end(), {p.x, p.y, p.z});
  return out;
}

// The stiffness between the components that are not held.
class Assembly {
 public:
  Assembly(const HexahedralMesh& mesh, std::span<const NodeSupport> supports)
      : number_(3 * mesh.points.size(), -2), prescribed_(mesh.points.size()) {
    for (const auto& element : mesh.elements)
      for (const int p : element) std::fill_n(number_.begin() + 3 * p, 3, 0);
    for (const NodeSupport& s : supports) {
      for (std::size_t c = 0; c < 3; ++c) {
        if (!s.held[c] || number_[3 * at(s.node) + c] == -2) continue;
        number_[3 * at(s.node) + c] = -1;
        prescribed_[at(s.node)][static_cast<int>(c)] = s.displacement_mm[static_cast<int>(c)];
      }
    }
    for (int& n : number_)
      if (n == 0) n = unknowns_++;
  }

  [[nodiscard]] int unknowns() const { return unknowns_; }
  [[nodiscard]] const std::vector<Vec3>& prescribed() const { return prescribed_; }
  /// Number of a component's unknown; −1: held, −2: of a point of no element.
  [[nodiscard]] int number(std::size_t value) const { return number_[value]; }

  [[nodiscard]] Eigen::SparseMatrix<double> matrix(const HexahedralMesh& mesh,
                                                   const ElasticBody& body) const {
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
      const auto& element = mesh.elements[e];
      const detail::HexMatrix k =
          detail::hex_stiffness(detail::gauss_points(of_corners(mesh.points, element)), body.of(e));
      for (int a = 0; a < 24; ++a) {
        const int row = number_[at(3 * element[at(a / 3)] + a % 3)];
        for (int b = 0; b < 24; ++b) {
          const int column = number_[at(3 * element[at(b / 3)] + b % 3)];
          if (column >= 0 && row >= column) entries.emplace_back(row, column, k(a, b));
        }
      }
    }
    Eigen::SparseMatrix<double> out(unknowns_, unknowns_);
    out.setFromTriplets(entries.begin(), entries.end());
    return out;
  }

 private:
  std::vector<int> number_;
  std::vector<Vec3> prescribed_;
  int unknowns_ = 0;
};

std::vector<Vec3> forces_of(const HexahedralMesh& mesh, const ElasticBody& body,
                            std::span<const Vec3> displacement_mm) {
  std::vector<Vec3> out(mesh.points.size());
  for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
    const auto& element = mesh.elements[e];
    const auto u = flat(of_corners(displacement_mm, element));
    const Eigen::Matrix<double, 24, 1> force =
        detail::hex_stiffness(detail::gauss_points(of_corners(mesh.points, element)), body.of(e)) *
        Eigen::Map<const Eigen::Matrix<double, 24, 1>>(u.data());
    for (int n = 0; n < 8; ++n) out[at(element[at(n)])] += {force[3 * n], force[3 * n + 1], force[3 * n + 2]};
  }
  return out;
}

Result<std::vector<Vec3>> load_of(const HexahedralMesh& mesh, const ElasticBody& body,
                                  const ElasticLoad& load) {
  std::vector<Vec3> force(mesh.points.size());
  TURGOR_CHECK(detail::add_point_and_surface_loads(mesh.points, load, force));
  for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
    const Vec3 weight = load.gravity_mm_ms2 * body.of(e).density_g_mm3;
    for (const HexPoint& g : detail::gauss_points(of_corners(mesh.points, mesh.elements[e])))
      for (int n = 0; n < 8; ++n) force[at(mesh.elements[e][at(n)])] += weight * (g.volume * g.shape[n]);
  }
  return force;
}

Result<void> check(const HexahedralMesh& mesh, const ElasticBody& body) {
  TURGOR_CHECK(check(mesh));
  return detail::check(body, mesh.elements.size());
}

}  // namespace

Result<std::vector<Vec3>> hexahedra_forces(const HexahedralMesh& mesh, const ElasticBody& body,
                                           std::span<const Vec3> displacement_mm) {
  TURGOR_CHECK(check(mesh, body));
  TURGOR_CHECK(detail::check_displacement(displacement_mm, mesh.points.size()));
  return forces_of(mesh, body, displacement_mm);
}

Result<std::vector<Vec3>> hexahedra_load(const HexahedralMesh& mesh, const ElasticBody& body,
                                         const ElasticLoad& load) {
  TURGOR_CHECK(check(mesh, body));
  return load_of(mesh, body, load);
}

Result<std::vector<ElementStress>> hexahedra_stress(const HexahedralMesh& mesh, const ElasticBody& body,
                                                    std::span<const Vec3> displacement_mm) {
  TURGOR_CHECK(check(mesh, body));
  TURGOR_CHECK(detail::check_displacement(displacement_mm, mesh.points.size()));
  std::vector<ElementStress> out;
  for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
    out.push_back(detail::hex_stress(detail::gauss_points(of_corners(mesh.points, mesh.elements[e])),
                                     body.of(e), of_corners(displacement_mm, mesh.elements[e])));
  }
  return out;
}

Result<ElasticSolution> solve_hexahedra(const HexahedralMesh& mesh, const ElasticBody& body,
                                        std::span<const NodeSupport> supports, const ElasticLoad& load,
                                        Context& context) {
  const Stage stage(context, "elasticity of hexahedra");
  TURGOR_CHECK(check(mesh, body));
  TURGOR_CHECK(detail::check(supports, mesh.points.size()));
  TURGOR_CHECK(detail::check_held(
      mesh.points, mesh.elements, [&](const auto& pair) { face_pairs(mesh, pair); }, supports));
  TURGOR_TRY(const std::vector<Vec3> load_n, load_of(mesh, body, load));
  TURGOR_CHECK(context.check());
  const Assembly assembly(mesh, supports);
  const std::vector<double> applied = flat(load_n);
  const auto unbalanced = [&](const std::vector<Vec3>& u) {
    const std::vector<double> inner = flat(forces_of(mesh, body, u));
    Eigen::VectorXd r(assembly.unknowns());
    for (std::size_t v = 0; v < applied.size(); ++v)
      if (assembly.number(v) >= 0) r[assembly.number(v)] = applied[v] - inner[v];
    return r;
  };
  ElasticSolution out;
  out.displacement_mm = assembly.prescribed();
  const Eigen::VectorXd right = unbalanced(out.displacement_mm);
  if (assembly.unknowns() > 0) {
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors(assembly.matrix(mesh, body));
    if (factors.info() != Eigen::Success)
      return Error{ErrorKind::internal, "the stiffness cannot be factored", "elasticity of hexahedra", ""};
    const Eigen::VectorXd solved = factors.solve(right);
    for (std::size_t v = 0; v < applied.size(); ++v)
      if (assembly.number(v) >= 0)
        out.displacement_mm[v / 3][static_cast<int>(v % 3)] = solved[assembly.number(v)];
  }
  if (right.norm() > 0) out.relative_residual = unbalanced(out.displacement_mm).norm() / right.norm();
  const std::vector<Vec3> forces = forces_of(mesh, body, out.displacement_mm);
  out.reaction_n.resize(mesh.points.size());
  for (std::size_t p = 0; p < mesh.points.size(); ++p) {
    out.strain_energy_nmm += 0.5 * dot(out.displacement_mm[p], forces[p]);
    for (int c = 0; c < 3; ++c)
      if (assembly.number(3 * p + at(c)) == -1) out.reaction_n[p][c] = forces[p][c] - load_n[p][c];
  }
  return out;
}

}  // namespace turgor
