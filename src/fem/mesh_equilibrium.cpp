#include "fem/mesh_equilibrium.hpp"

#include <algorithm>
#include <cmath>

#include "fem/elastic_problem.hpp"
#include "turgor/core/index.hpp"

namespace turgor::detail {
namespace {

constexpr int kHeld = -1, kAlone = -2;

}  // namespace

MeshEquilibrium::MeshEquilibrium(const ElementMesh& mesh, const ElementModel& model,
                                 const ElasticSupports& supports, std::span<const Vec3> load_n)
    : mesh_(mesh),
      model_(model),
      contacts_(supports.contacts),
      load_n_(load_n),
      number_(3 * mesh.points.size(), kAlone),
      prescribed_(mesh.points.size()) {
  for (std::size_t e = 0; e < mesh.size(); ++e)
    for (const int p : model.corners(e)) std::fill_n(number_.begin() + 3 * p, 3, 0);
  for (const NodeSupport& s : supports.nodes) {
    for (int c = 0; c < 3; ++c) {
      if (!s.held[at(c)] || number(s.node, c) == kAlone) continue;
      number_[3 * at(s.node) + at(c)] = kHeld;
      prescribed_[at(s.node)][c] = s.displacement_mm[c];
    }
  }
  for (int& n : number_)
    if (n == 0) n = unknowns_++;
  Box3 box;
  for (std::size_t p = 0; p < mesh.points.size(); ++p) {
    if (number_[3 * p] == kAlone) continue;
    box.extend(mesh.points[p]);
    farthest_mm_ = std::max(farthest_mm_, length(prescribed_[p]));
  }
  farthest_mm_ = 1000 * (farthest_mm_ + length(box.size()));
}

bool MeshEquilibrium::carried_off(const std::vector<Vec3>& displacement_mm) const {
  return std::any_of(displacement_mm.begin(), displacement_mm.end(),
                     [&](const Vec3& u) { return !(length(u) <= farthest_mm_); });
}

int MeshEquilibrium::number(int point, int component) const {
  return number_[3 * at(point) + at(component)];
}

std::vector<Vec3> MeshEquilibrium::with_prescribed(std::vector<Vec3> displacement_mm, double part) const {
  for (std::size_t p = 0; p < displacement_mm.size(); ++p)
    for (int c = 0; c < 3; ++c)
      if (number_[3 * p + at(c)] == kHeld) displacement_mm[p][c] = part * prescribed_[p][c];
  return displacement_mm;
}

std::vector<Vec3> MeshEquilibrium::moved(std::vector<Vec3> displacement_mm, const Eigen::VectorXd& step,
                                         double factor) const {
  for (std::size_t v = 0; v < number_.size(); ++v)
    if (number_[v] >= 0) displacement_mm[v / 3][static_cast<int>(v % 3)] += factor * step[number_[v]];
  return displacement_mm;
}

MeshState MeshEquilibrium::evaluate(std::vector<Vec3> displacement_mm, double part) const {
  MeshState state;
  state.elements = model_.evaluate(displacement_mm);
  state.potential_nmm = state.size_nmm = state.elements.energy_nmm;
  std::vector<Vec3> forces(load_n_.begin(), load_n_.end());
  double loads = 0, reactions = 0;
  for (std::size_t p = 0; p < forces.size(); ++p) {
    forces[p] *= number_[3 * p] == kAlone ? 0 : part;
    const double work = dot(forces[p], displacement_mm[p]);
    state.potential_nmm -= work, state.size_nmm += std::abs(work);
    loads += squared_length(forces[p]);
    forces[p] -= state.elements.force_n[p];
  }
  for (const Contact& contact : contacts_) {
    if (number(contact.point, 0) == kAlone) continue;
    const ContactResponse r =
        respond(contact, mesh_.points[at(contact.point)] + displacement_mm[at(contact.point)]);
    state.potential_nmm += r.energy, state.size_nmm += r.energy;
    forces[at(contact.point)] += r.force_n;
    reactions += squared_length(r.force_n);
  }
  state.unbalanced.resize(unknowns_);
  for (std::size_t v = 0; v < number_.size(); ++v) {
    const double force = forces[v / 3][static_cast<int>(v % 3)];
    if (number_[v] >= 0) state.unbalanced[number_[v]] = force;
    if (number_[v] == kHeld) reactions += force * force;
  }
  state.carried_n = std::sqrt(std::max(loads, reactions));
  if (!std::isfinite(state.potential_nmm) && state.valid()) state.elements.turned_over = 1;
  state.displacement_mm = std::move(displacement_mm);
  return state;
}

MeshEquilibrium::Matrix MeshEquilibrium::stiffness(const MeshState& state, bool definite,
                                                   std::span<const Vec3> moves,
                                                   Eigen::VectorXd& right) const {
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](int a, int b, const Eigen::Matrix3d& block) {
    for (int i = 0; i < 3; ++i) {
      const int row = number(a, i);
      if (row < 0) continue;
      for (int j = 0; j < 3; ++j) {
        const int column = number(b, j);
        if (column >= 0 && row >= column) entries.emplace_back(row, column, block(i, j));
        if (column == kHeld && !moves.empty()) right[row] -= block(i, j) * moves[at(b)][j];
      }
    }
  };
  model_.add_stiffness(state.displacement_mm, state.elements, definite, add);
  for (const Contact& c : contacts_) {
    if (number(c.point, 0) == kAlone) continue;
    const double k = respond(c, mesh_.points[at(c.point)] + state.displacement_mm[at(c.point)]).slope;
    const Eigen::Vector3d n(c.normal.x, c.normal.y, c.normal.z);
    add(c.point, c.point, k * n * n.transpose());
  }
  Matrix out(unknowns_, unknowns_);
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

bool MeshEquilibrium::factor(const Matrix& matrix) {
  if (!analyzed_) factors_.analyzePattern(matrix);
  analyzed_ = true;
  factors_.factorize(matrix);
  return factors_.info() == Eigen::Success;
}

bool MeshEquilibrium::positive() const {
  return factors_.info() == Eigen::Success && factors_.vectorD().minCoeff() > 0;
}

std::optional<MeshEquilibrium::Step> MeshEquilibrium::newton_step(const MeshState& state,
                                                                  std::span<const Vec3> moves,
                                                                  Tangent tangent) {
  Step out;
  out.right = state.unbalanced, out.step = state.unbalanced;
  if (unknowns_ == 0) return out;
  Matrix matrix = stiffness(state, tangent == Tangent::definite, moves, out.right);
  bool done = factor(matrix);
  if (tangent == Tangent::definite) {
    const double mean = matrix.diagonal().cwiseAbs().mean();
    for (double more = 1e-8; !(done = positive()) && more < 1e4; more *= 100) {
      for (Eigen::Index i = 0; i < unknowns_; ++i) matrix.coeffRef(i, i) += more * mean;
      factor(matrix);
    }
  }
  if (!done) return {};
  out.stable = positive();
  out.step = factors_.solve(out.right);
  if (!out.step.allFinite()) return {};
  return out;
}

std::vector<Vec3> MeshEquilibrium::reactions(const MeshState& state, double part) const {
  std::vector<Vec3> out(mesh_.points.size());
  for (const Contact& c : contacts_)
    if (number(c.point, 0) != kAlone)
      out[at(c.point)] = respond(c, mesh_.points[at(c.point)] + state.displacement_mm[at(c.point)]).force_n;
  for (std::size_t p = 0; p < out.size(); ++p)
    for (int c = 0; c < 3; ++c)
      if (number_[3 * p + at(c)] == kHeld) out[p][c] = state.elements.force_n[p][c] - part * load_n_[p][c];
  return out;
}

}  // namespace turgor::detail
