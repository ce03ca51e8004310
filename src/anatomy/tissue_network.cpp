#include "turgor/anatomy/tissue_network.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "turgor/core/index.hpp"

namespace turgor {
namespace {

// A spring of one prism with the stiffness that the prism contributes.
struct Share {
  std::int64_t
      key;  // smaller point number × points + larger: equal for the same spring of neighbouring prisms
  SpringKind kind;
  SpringLaw law;
  double stiffness_length;  // k L0, N·mm
};

// The three tetrahedra of a prism (a b c outer, d e f inner). The diagonals start at the smaller column
// numbers, so neighbouring prisms split their common face alike. Positive volume needs the triangle turned
// inwards.
std::array<std::array<int, 4>, 3> split_prism(std::array<int, 3> column, std::array<int, 3> outer,
                                              std::array<int, 3> inner) {
  while (column[0] > column[1] || column[0] > column[2]) {
    std::rotate(column.begin(), column.begin() + 1, column.end());
    std::rotate(outer.begin(), outer.begin() + 1, outer.end());
    std::rotate(inner.begin(), inner.begin() + 1, inner.end());
  }
  const auto [a, b, c] = outer;
  const auto [d, e, f] = inner;
  if (column[1] < column[2]) return {{{a, d, f, e}, {a, b, e, f}, {a, b, f, c}}};
  return {{{a, d, f, e}, {a, c, e, f}, {a, b, e, c}}};
}

// The value of a layer; the last one given goes for the layers beyond.
template <class T>
T of_layer(const std::vector<T>& values, int layer) {
  return values[std::min(at(layer), values.size() - 1)];
}

Result<void> check(const TissueMaterial& material) {
  const bool positive = !material.young_mpa.empty() && !material.laws.empty() &&
                        std::all_of(material.young_mpa.begin(), material.young_mpa.end(),
                                    [](double e) { return std::isfinite(e) && e > 0; });
  if (!positive || !(material.poisson >= 0.25 && material.poisson <= 0.49)) {
    return Error{ErrorKind::bad_command,
                 "the tissue's moduli must be positive and its Poisson's ratio 0.25 to 0.49", "material",
                 "Correct the values of the command material"};
  }
  return {};
}

// All springs, merged where prisms share them.
std::vector<Spring> merge(std::vector<Share>& shares, const std::vector<Vec3>& points) {
  std::stable_sort(shares.begin(), shares.end(),
                   [](const Share& x, const Share& y) { return x.key < y.key; });
  std::vector<Spring> springs;
  const auto n = static_cast<std::int64_t>(points.size());
  for (std::size_t i = 0; i < shares.size();) {
    Spring s;
    s.a = static_cast<int>(shares[i].key / n);
    s.b = static_cast<int>(shares[i].key % n);
    s.kind = shares[i].kind;
    s.law = shares[i].law;  // between two layers that of the outer one
    s.rest_length_mm = distance(points[at(s.a)], points[at(s.b)]);
    double product = 0;
    for (const std::int64_t key = shares[i].key; i < shares.size() && shares[i].key == key; ++i) {
      product += shares[i].stiffness_length;
    }
    // k ε is the force of the linear law at strain ε, and the energy density of the springs is k L0 ε² / 2 V.
    s.stiffness_n = product / s.rest_length_mm;
    springs.push_back(s);
  }
  return springs;
}

}  // namespace

Result<SpringNetwork> make_network(const LayeredTissue& tissue, const TissueMaterial& material) {
  TURGOR_CHECK(check(material));
  SpringNetwork network;
  network.rest = tissue.points;
  network.mass_g.assign(tissue.points.size(), 0.0);
  std::vector<Share> shares;
  shares.reserve(tissue.surface.triangles.size() * at(tissue.sheets - 1) * 15);
  const auto n = static_cast<std::int64_t>(tissue.points.size());
  const auto share = [&](int p, int q, SpringKind kind, SpringLaw law, double product) {
    shares.push_back({std::min(p, q) * n + std::max(p, q), kind, law, product});
  };
  for (int layer = 0; layer + 1 < tissue.sheets; ++layer) {
    const SpringLaw law = of_layer(material.laws, layer);
    const double young = of_layer(material.young_mpa, layer);
    // Bulk modulus beyond that of the springs alone, 2E/3 (Poisson's ratio 1/4).
    const double bulk = young / (3 * (1 - 2 * material.poisson)) - 2 * young / 3;
    for (const Index3& t : tissue.surface.triangles) {
      std::array<int, 3> outer{}, inner{};
      for (std::size_t i = 0; i < 3; ++i) {
        outer[i] = tissue.point(layer, t[i]);
        inner[i] = tissue.point(layer + 1, t[i]);
      }
      double volume = 0;
      for (const auto& q : split_prism(t, outer, inner)) {
        const auto& x = tissue.points;
        const double v = signed_volume(x[at(q[0])], x[at(q[1])], x[at(q[2])], x[at(q[3])]);
        if (!(v > 0)) return Error{ErrorKind::internal, "a prism of the tissue has no volume", "tissue", ""};
        volume += v;
        if (bulk > 0)
          network.volumes.push_back({{q[0], q[1], q[2], q[3]}, v, bulk, material.inversion_guard_mpa});
      }
      const double product = 6 * young * volume / 15;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3;
        share(outer[i], outer[j], SpringKind::membrane, law, product);
        share(inner[i], inner[j], SpringKind::membrane, law, product);
        share(outer[i], inner[i], SpringKind::vertical, law, product);
        share(outer[i], inner[j], SpringKind::diagonal, law, product);
        share(inner[i], outer[j], SpringKind::diagonal, law, product);
        network.mass_g[at(outer[i])] += material.density_g_mm3 * volume / 6;
        network.mass_g[at(inner[i])] += material.density_g_mm3 * volume / 6;
      }
    }
  }
  network.springs = merge(shares, network.rest);
  TURGOR_CHECK(validate(network));
  return network;
}

int spring_count(const LayeredTissue& tissue) {
  const int edges = static_cast<int>(point_adjacency(tissue.surface).neighbours.size()) / 2;
  return edges * tissue.sheets + (tissue.columns() + 2 * edges) * (tissue.sheets - 1);
}

Result<SpringNetwork> make_chain_network(const LayeredTissue& tissue) {
  SpringNetwork network;
  network.rest = tissue.points;
  network.mass_g.assign(tissue.points.size(), 1.0);
  std::vector<Share> shares;
  const auto n = static_cast<std::int64_t>(tissue.points.size());
  for (int layer = 0; layer + 1 < tissue.sheets; ++layer) {
    for (const Index3& t : tissue.surface.triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        const int p = tissue.point(layer, t[i]), q = tissue.point(layer, t[(i + 1) % 3]);
        shares.push_back({std::min(p, q) * n + std::max(p, q), SpringKind::membrane, SpringLaw::linear, 1.0});
        shares.push_back(
            {p * n + tissue.point(layer + 1, t[i]), SpringKind::vertical, SpringLaw::linear, 1.0});
      }
    }
  }
  network.springs = merge(shares, network.rest);
  TURGOR_CHECK(validate(network));
  return network;
}

}  // namespace turgor
