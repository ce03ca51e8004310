#include "fem/element_model.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "fem/elastic_problem.hpp"
#include "fem/law_stress.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor::detail {
namespace {

// Elements done by one task.
constexpr std::size_t kGrain = 64;

Eigen::Vector3d eigen(const Vec3& v) {
  return {v.x, v.y, v.z};
}

Eigen::Matrix<double, 9, 9> without_negative_curvature(const Eigen::Matrix<double, 9, 9>& c) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(c);
  if (solver.eigenvalues()[0] >= 0) return c;
  return solver.eigenvectors() * solver.eigenvalues().cwiseMax(0).asDiagonal() *
         solver.eigenvectors().transpose();
}

Result<void> check_size(const ElementMesh& mesh) {
  if (mesh.size() > 0 && mesh.size() <= 10'000'000 && mesh.points.size() <= 100'000'000) return {};
  return bad_elasticity(fmt::format("there are {} elements over {} points", mesh.size(), mesh.points.size()),
                        "mesh", "Give a mesh of thousands of elements");
}

}  // namespace

std::span<const int> corners_of(const ElementMesh& mesh, std::size_t e) {
  if (e < mesh.hexahedra.size()) return mesh.hexahedra[e];
  e -= mesh.hexahedra.size();
  if (e < mesh.prisms.size()) return mesh.prisms[e];
  return mesh.tetrahedra[e - mesh.prisms.size()];
}

Result<ElementModel> ElementModel::prepare(const ElementMesh& mesh, const ElasticBody& body) {
  TURGOR_CHECK(check_size(mesh));
  TURGOR_CHECK(check(body, mesh.size()));
  ElementModel model;
  model.point_count_ = mesh.points.size();
  for (std::size_t e = 0; e < mesh.size(); ++e) {
    const std::span<const int> nodes = corners_of(mesh, e);
    std::array<Vec3, 8> place;
    Element element;
    element.corners = nodes.size(), element.first = model.gauss_.size(), element.material = body.of(e);
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      if (nodes[n] < 0 || at(nodes[n]) >= mesh.points.size())
        return bad_elasticity(fmt::format("there is no point {}", nodes[n]), fmt::format("element {}", e),
                              "Repair the mesh");
      element.corner[n] = nodes[n], place[n] = mesh.points[at(nodes[n])];
    }
    add_gauss_points(std::span(place).first(nodes.size()), model.gauss_);
    element.count = model.gauss_.size() - element.first;
    for (std::size_t g = element.first; g < model.gauss_.size(); ++g) {
      const double volume = model.gauss_[g].volume;
      if (!(volume > 0) || !std::isfinite(volume) || !std::isfinite(1 / volume))
        return bad_elasticity("the element is turned over or has no volume", fmt::format("element {}", e),
                              "Repair the mesh");
      element.volume += volume;
    }
    model.elements_.push_back(element);
  }
  model.make_patches(mesh, body);
  return model;
}

void ElementModel::make_patches(const ElementMesh& mesh, const ElasticBody& body) {
  std::map<std::pair<int, int>, int> of_point;  // point and material
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    Element& element = elements_[e];
    const int material = body.material.empty() ? 0 : body.material[e];
    if (e < mesh.hexahedra.size()) {
      element.patch[element.patches++] = static_cast<int>(patches_.size());
      patches_.emplace_back();
    } else {
      for (const int node : element.nodes()) {
        const auto [at, added] = of_point.try_emplace({node, material}, static_cast<int>(patches_.size()));
        if (added) patches_.emplace_back();
        element.patch[element.patches++] = at->second;
      }
    }
    for (std::size_t p = 0; p < element.patches; ++p) {
      Patch& patch = patches_[at(element.patch[p])];
      patch.volume += element.share() * element.volume;
      patch.stiffness += element.share() * element.volume * element.material.bulk_modulus();
      patch.elements.push_back(static_cast<int>(e));
      patch.nodes.insert(patch.nodes.end(), element.nodes().begin(), element.nodes().end());
    }
  }
  for (Patch& patch : patches_) {
    std::sort(patch.nodes.begin(), patch.nodes.end());
    patch.nodes.erase(std::unique(patch.nodes.begin(), patch.nodes.end()), patch.nodes.end());
  }
}

bool ElementModel::linear() const {
  return std::all_of(elements_.begin(), elements_.end(),
                     [](const Element& e) { return e.material.law == ElasticLaw::linear; });
}

// h = Σ u ∇Nᵀ.
Tensor<double> ElementModel::gradient(const Element& e, std::size_t g, std::span<const Vec3> u) const {
  Tensor<double> h{};
  for (std::size_t n = 0; n < e.corners; ++n) {
    const Vec3 &moved = u[at(e.corner[n])], &slope = gauss_[g].gradient[n];
    for (int i = 0; i < 9; ++i) h.m[i] += moved[i / 3] * slope[i % 3];
  }
  return h;
}

ElementState ElementModel::evaluate(std::span<const Vec3> displacement_mm) const {
  ElementState state;
  state.point.resize(gauss_.size());
  parallel_for(elements_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e)
      for (std::size_t g = elements_[e].first; g < elements_[e].first + elements_[e].count; ++g)
        state.point[g] = law_response(elements_[e].material, gradient(elements_[e], g, displacement_mm));
  });
  std::vector<double> theta(patches_.size());  // Σ w θ of each patch
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const Element& element = elements_[e];
    bool valid = true;
    double whole = 0;
    for (std::size_t g = element.first; g < element.first + element.count; ++g) {
      valid = valid && state.point[g].valid;
      state.energy_nmm += gauss_[g].volume * state.point[g].energy;
      whole += gauss_[g].volume * state.point[g].theta;
    }
    for (std::size_t p = 0; p < element.patches; ++p) theta[at(element.patch[p])] += element.share() * whole;
    if (!valid && state.turned_over++ == 0) state.first_turned_over = e;
  }
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    theta[p] /= patches_[p].volume;
    state.energy_nmm += 0.5 * patches_[p].stiffness * theta[p] * theta[p];
  }
  if (!std::isfinite(state.energy_nmm) && state.valid()) state.turned_over = 1;
  state.force_n.resize(point_count_);
  for (const Element& element : elements_) {
    double pressure = 0;
    for (std::size_t p = 0; p < element.patches; ++p) {
      const auto number = at(element.patch[p]);
      pressure += element.share() * patches_[number].stiffness / patches_[number].volume * theta[number];
    }
    state.pressure_mpa.push_back(pressure);
    if (state.valid()) add_forces(element, displacement_mm, pressure, state);
  }
  state.rounding_n = std::numeric_limits<double>::epsilon() * std::sqrt(state.rounding_n);
  return state;
}

void ElementModel::add_forces(const Element& e, std::span<const Vec3> u, double pressure,
                              ElementState& state) const {
  const double modulus = e.material.bulk_modulus() + 2 * e.material.shear_modulus();
  for (std::size_t g = e.first; g < e.first + e.count; ++g) {
    const GaussPoint& point = gauss_[g];
    const Tensor<double> stress = state.point[g].stress + state.point[g].theta_gradient * pressure;
    double slopes = 0, turned = 0;
    for (std::size_t n = 0; n < e.corners; ++n) {
      const Vec3& slope = point.gradient[n];
      Vec3& force = state.force_n[at(e.corner[n])];
      for (int i = 0; i < 3; ++i)
        force[i] += point.volume * (stress(i, 0) * slope.x + stress(i, 1) * slope.y + stress(i, 2) * slope.z);
      slopes += length(slope), turned += length(slope) * length(u[at(e.corner[n])]);
    }
    const double wrong = point.volume * slopes * modulus * turned;
    state.rounding_n += wrong * wrong;
  }
}

ElementModel::ElementMatrix ElementModel::stiffness(const Element& e, std::span<const Vec3> u,
                                                    double pressure, bool definite) const {
  const auto size = static_cast<Eigen::Index>(3 * e.corners);
  ElementMatrix k = ElementMatrix::Zero(size, size);
  Eigen::Matrix<double, 9, Eigen::Dynamic, 0, 9, 24> slopes(9, size);  // dF of each unknown
  slopes.setZero();
  for (std::size_t g = e.first; g < e.first + e.count; ++g) {
    Eigen::Matrix<double, 9, 9> c = law_tangent(e.material, gradient(e, g, u), pressure);
    if (definite) c = without_negative_curvature(c);
    for (std::size_t n = 0; n < e.corners; ++n)
      for (int i = 0; i < 3; ++i)
        slopes.block<3, 1>(3 * i, static_cast<Eigen::Index>(3 * n) + i) = eigen(gauss_[g].gradient[n]);
    k.noalias() += slopes.transpose() * (gauss_[g].volume * (c * slopes));
  }
  return k;
}

void ElementModel::add_stiffness(std::span<const Vec3> displacement_mm, const ElementState& state,
                                 bool definite, const AddBlock& add) const {
  std::vector<ElementMatrix> matrices(elements_.size());
  parallel_for(elements_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e)
      matrices[e] = stiffness(elements_[e], displacement_mm, state.pressure_mpa[e], definite);
  });
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const std::span<const int> nodes = elements_[e].nodes();
    for (std::size_t a = 0; a < nodes.size(); ++a)
      for (std::size_t b = 0; b < nodes.size(); ++b)
        add(nodes[a], nodes[b],
            matrices[e].block<3, 3>(static_cast<Eigen::Index>(3 * a), static_cast<Eigen::Index>(3 * b)));
  }
  for (const Patch& patch : patches_) add_patch(patch, state, add);
}

// K / V b bᵀ, b = Σ share w ∂θ/∂F ∇N.
void ElementModel::add_patch(const Patch& patch, const ElementState& state, const AddBlock& add) const {
  std::vector<Vec3> b(patch.nodes.size());
  for (const int number : patch.elements) {
    const Element& e = elements_[at(number)];
    for (std::size_t n = 0; n < e.corners; ++n) {
      const auto place = std::lower_bound(patch.nodes.begin(), patch.nodes.end(), e.corner[n]);
      Vec3& sum = b[static_cast<std::size_t>(place - patch.nodes.begin())];
      for (std::size_t g = e.first; g < e.first + e.count; ++g) {
        const Tensor<double>& t = state.point[g].theta_gradient;
        const Vec3 slope = gauss_[g].gradient[n] * (e.share() * gauss_[g].volume);
        for (int i = 0; i < 3; ++i) sum[i] += t(i, 0) * slope.x + t(i, 1) * slope.y + t(i, 2) * slope.z;
      }
    }
  }
  const double scale = patch.stiffness / (patch.volume * patch.volume);
  for (std::size_t i = 0; i < b.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j)
      add(patch.nodes[i], patch.nodes[j], scale * eigen(b[i]) * eigen(b[j]).transpose());
}

Result<std::vector<ElementStress>> ElementModel::stress(std::span<const Vec3> displacement_mm,
                                                        const ElementState& state) const {
  std::vector<ElementStress> out(elements_.size());
  const std::size_t none = elements_.size();
  const std::size_t bad = parallel_reduce<std::size_t>(
      elements_.size(), kGrain, none,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t e = begin; e < end; ++e)
          if (!stress_of(e, displacement_mm, state, out[e])) return e;
        return none;
      },
      [](std::size_t a, std::size_t b) { return std::min(a, b); });
  if (bad < none) return turned_over(bad);
  return out;
}

bool ElementModel::stress_of(std::size_t e, std::span<const Vec3> displacement_mm, const ElementState& state,
                             ElementStress& out) const {
  const Element& element = elements_[e];
  StressMean mean(element.material, state.pressure_mpa[e]);
  for (std::size_t g = element.first; g < element.first + element.count; ++g)
    if (!mean.add(gradient(element, g, displacement_mm), state.point[g], gauss_[g].volume / element.volume))
      return false;
  out = mean.stress();
  return true;
}

void ElementModel::add_gravity(const Vec3& acceleration, std::vector<Vec3>& force_n) const {
  for (const Element& e : elements_) {
    const Vec3 weight = acceleration * e.material.density_g_mm3;
    for (std::size_t g = e.first; g < e.first + e.count; ++g)
      for (std::size_t n = 0; n < e.corners; ++n)
        force_n[at(e.corner[n])] += weight * (gauss_[g].volume * gauss_[g].shape[n]);
  }
}

Error turned_over(std::size_t element) {
  return bad_elasticity("the displacement turns the element over, where its law has no energy",
                        fmt::format("element {}", element), "Give a smaller displacement");
}

}  // namespace turgor::detail
