// The springs and volumes of flesh.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "anatomy/flesh_prisms.hpp"
#include "turgor/anatomy/flesh.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

// Of a fan about one point there are more plates than any tissue has: half the square of its polygons.
constexpr std::size_t kMostSprings = 200'000'000;

// Two columns that a spring joins in every layer.
struct Link {
  Edge columns;
  SpringKind kind;
};

// The points that edges join to each point, ascending.
struct Neighbours {
  std::vector<std::size_t> offsets;
  std::vector<int> points;

  Neighbours(const Polyhedron& surface) : offsets(surface.points.size() + 1, 0) {
    const std::vector<Edge> all = edges(surface);
    for (const auto& [a, b] : all) ++offsets[at(a) + 1], ++offsets[at(b) + 1];
    for (std::size_t i = 1; i < offsets.size(); ++i) offsets[i] += offsets[i - 1];
    points.resize(2 * all.size());
    std::vector<std::size_t> next(offsets.begin(), offsets.end() - 1);
    // Ascending edges fill each list in order: first the smaller neighbours, then the larger.
    for (const auto& [a, b] : all) points[next[at(b)]++] = a;
    for (const auto& [a, b] : all) points[next[at(a)]++] = b;
  }
  [[nodiscard]] std::span<const int> of(int point) const {
    return std::span(points).subspan(offsets[at(point)], offsets[at(point) + 1] - offsets[at(point)]);
  }
};

// Pairs of membranes that share a point, counted as often as they do so.
std::size_t plate_count(const Neighbours& neighbours) {
  std::size_t count = 0;
  for (std::size_t i = 0; i + 1 < neighbours.offsets.size(); ++i) {
    const std::size_t n = neighbours.offsets[i + 1] - neighbours.offsets[i];
    count += n * (n - 1) / 2;
  }
  return count;
}

// The links from `point` to points of larger numbers, ascending.
void append_links(const Neighbours& neighbours, int point, std::vector<int>& scratch,
                  std::vector<Link>& links) {
  scratch.clear();
  const auto membranes = neighbours.of(point);
  for (const int q : membranes) {
    if (q > point) scratch.push_back(q);
    const auto beyond = neighbours.of(q);
    scratch.insert(scratch.end(), std::upper_bound(beyond.begin(), beyond.end(), point), beyond.end());
  }
  std::sort(scratch.begin(), scratch.end());
  scratch.erase(std::unique(scratch.begin(), scratch.end()), scratch.end());
  for (const int q : scratch) {
    const bool membrane = std::binary_search(membranes.begin(), membranes.end(), q);
    links.push_back({{point, q}, membrane ? SpringKind::membrane : SpringKind::plate});
  }
}

// The springs of one layer, in every layer alike, ascending.
Result<std::vector<Link>> layer_links(const Flesh& flesh) {
  const Neighbours neighbours(flesh.surface);
  if (plate_count(neighbours) > kMostSprings / (3 * at(flesh.layers))) {
    return Error{ErrorKind::bad_input, fmt::format("it would have more than {} springs", kMostSprings),
                 "flesh", "Take a coarser surface, fewer layers, or fewer polygons about one point"};
  }
  constexpr std::size_t grain = 2048;
  const std::size_t columns = flesh.surface.points.size();
  std::vector<std::vector<Link>> parts((columns + grain - 1) / grain);
  parallel_for(columns, grain, [&](std::size_t begin, std::size_t end) {
    std::vector<int> scratch;
    for (std::size_t i = begin; i < end; ++i) {
      append_links(neighbours, static_cast<int>(i), scratch, parts[begin / grain]);
    }
  });
  std::vector<Link> links;
  for (const std::vector<Link>& part : parts) links.insert(links.end(), part.begin(), part.end());
  return links;
}

Spring make_spring(const Flesh& flesh, int a, int b, SpringKind kind) {
  const FleshSample& p = flesh.samples[at(a)];
  const FleshSample& q = flesh.samples[at(b)];
  const double spacing = (p.spacing + q.spacing) / 2;
  Spring s;
  s.a = a;
  s.b = b;
  s.kind = kind;
  s.law = flesh.law;
  s.rest_length_mm = distance(p.rest, q.rest) * ((p.growth + q.growth) / 2);
  s.stiffness_n = flesh.stiffness_n * ((p.stiffness + q.stiffness) / 2) * spacing;
  // Half the spacing makes twice the springs across a line, four times those through an area.
  if (kind == SpringKind::vertical) s.stiffness_n *= spacing;
  return s;
}

void add_springs(const Flesh& flesh, const std::vector<Link>& links, FleshNetwork& result) {
  const std::size_t columns = flesh.surface.points.size();
  const std::size_t in_layer = links.size(), to_next = columns + 2 * links.size();
  const std::size_t layers = at(flesh.layers);
  std::vector<Spring>& springs = result.network.springs;
  springs.resize(layers * in_layer + (layers - 1) * to_next);
  result.layer_of_spring.resize(springs.size());
  for (int layer = 0; layer < flesh.layers; ++layer) {
    const std::size_t first = at(layer) * (in_layer + to_next);
    const std::size_t end = std::min(first + in_layer + to_next, springs.size());
    std::fill(result.layer_of_spring.begin() + static_cast<std::ptrdiff_t>(first),
              result.layer_of_spring.begin() + static_cast<std::ptrdiff_t>(end), layer);
    const bool last = layer + 1 == flesh.layers;
    parallel_for(links.size(), 4096, [&](std::size_t begin, std::size_t stop) {
      for (std::size_t i = begin; i < stop; ++i) {
        const auto [a, b] = links[i].columns;
        const int low_a = flesh.sample(layer, a), low_b = flesh.sample(layer, b);
        springs[first + i] = make_spring(flesh, low_a, low_b, links[i].kind);
        if (last) continue;
        const std::size_t diagonal = first + in_layer + columns + 2 * i;
        const int up_a = flesh.sample(layer + 1, a), up_b = flesh.sample(layer + 1, b);
        springs[diagonal] = make_spring(flesh, low_a, up_b, SpringKind::diagonal);
        springs[diagonal + 1] = make_spring(flesh, low_b, up_a, SpringKind::diagonal);
      }
    });
    for (int column = 0; !last && column < flesh.columns(); ++column) {
      springs[first + in_layer + at(column)] = make_spring(
          flesh, flesh.sample(layer, column), flesh.sample(layer + 1, column), SpringKind::vertical);
    }
  }
}

double mean_growth(const Flesh& flesh, const std::array<int, 4>& corners) {
  double growth = 0;
  for (const int p : corners) growth += flesh.samples[at(p)].growth / 4;
  return growth;
}

Result<void> add_volumes(const Flesh& flesh, SpringNetwork& network) {
  const Polyhedron bases = detail::prism_bases(flesh);
  for (int layer = 0; layer + 1 < flesh.layers; ++layer) {
    for (int i = 0; i < bases.polygon_count(); ++i) {
      const auto base = bases.polygon(i);
      // The corners of a prism overlap: six of a third of its volume, or eight of a sixth.
      const double share = base.size() == 3 ? 1.0 / 2 : 3.0 / 4;
      bool sound = true;
      detail::visit_corners(flesh, base, layer, [&](const std::array<int, 4>& t) {
        const auto& x = network.rest;
        const double volume = signed_volume(x[at(t[0])], x[at(t[1])], x[at(t[2])], x[at(t[3])]);
        const double growth = mean_growth(flesh, t);
        sound = sound && volume > 0;
        network.volumes.push_back({{t[0], t[1], t[2], t[3]},
                                   volume * growth * growth * growth,
                                   share * flesh.volume_modulus_mpa,
                                   share * flesh.inversion_guard_mpa});
      });
      if (sound) continue;
      return Error{ErrorKind::bad_input,
                   fmt::format("the tissue above layer {} is turned over at column {}", layer, base[0]),
                   "flesh", "Make it thinner there, or the surface smoother"};
    }
  }
  return {};
}

}  // namespace

Result<FleshNetwork> make_network(const Flesh& flesh) {
  TURGOR_CHECK(validate(flesh));
  TURGOR_TRY(const std::vector<Link> links, layer_links(flesh));
  FleshNetwork result;
  for (const FleshSample& sample : flesh.samples) {
    result.network.rest.push_back(sample.rest);
    result.network.mass_g.push_back(sample.mass_g);
  }
  add_springs(flesh, links, result);
  if (flesh.volume_modulus_mpa > 0 || flesh.inversion_guard_mpa > 0) {
    TURGOR_CHECK(add_volumes(flesh, result.network));
  }
  TURGOR_CHECK(validate(result.network));
  return result;
}

}  // namespace turgor
