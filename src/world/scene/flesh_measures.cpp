// What can be measured on tissue: openings, thickness, bulges, depth in what it lies on.
#include <algorithm>
#include <map>

#include "turgor/core/index.hpp"
#include "turgor/world/flesh_objects.hpp"

namespace turgor {
namespace {

// Loops of the boundary of a surface, each by its points in order.
std::vector<std::vector<int>> boundary_loops(const Polyhedron& surface) {
  std::map<Edge, int> uses;
  for (int p = 0; p < surface.polygon_count(); ++p) {
    const auto corners = surface.polygon(p);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const auto [low, high] = std::minmax(corners[i], corners[(i + 1) % corners.size()]);
      ++uses[{low, high}];
    }
  }
  std::multimap<int, int> next;
  for (const auto& [edge, count] : uses) {
    if (count == 1) next.emplace(edge[0], edge[1]), next.emplace(edge[1], edge[0]);
  }
  std::vector<std::vector<int>> loops;
  const auto take = [&](int from, int to) {
    for (auto [i, end] = next.equal_range(from); i != end; ++i) {
      if (i->second != to) continue;
      next.erase(i);
      return;
    }
  };
  while (!next.empty()) {
    std::vector<int> loop{next.begin()->first};
    for (auto step = next.find(loop.back()); step != next.end(); step = next.find(loop.back())) {
      const int from = loop.back(), to = step->second;
      take(from, to), take(to, from);
      loop.push_back(to);
    }
    loop.pop_back();  // the first point again
    loops.push_back(std::move(loop));
  }
  return loops;
}

double perimeter(const std::vector<int>& loop, const std::vector<Vec3>& x) {
  double sum = 0;
  for (std::size_t i = 0; i < loop.size(); ++i)
    sum += distance(x[at(loop[i])], x[at(loop[(i + 1) % loop.size()])]);
  return sum;
}

double area(const std::vector<int>& loop, const std::vector<Vec3>& x) {
  Vec3 sum;
  for (std::size_t i = 0; i < loop.size(); ++i)
    sum += cross(x[at(loop[i])], x[at(loop[(i + 1) % loop.size()])]);
  return 0.5 * length(sum);
}

struct Skin {
  std::vector<Vec3> now, rest;
};

Skin skin_of(const Flesh& flesh, const std::vector<Vec3>& positions) {
  Skin skin;
  for (int c = 0; c < flesh.columns(); ++c) {
    const std::size_t sample = at(flesh.sample(flesh.layers - 1, c));
    skin.now.push_back(positions[sample]);
    skin.rest.push_back(flesh.samples[sample].rest);
  }
  return skin;
}

// Heights over the mean level of the outer boundary.
std::vector<double> heights(const Flesh& flesh, const Skin& skin, const std::vector<int>& outer) {
  Vec3 normal;
  for (const Vec3& n : vertex_normals(flesh.surface)) normal += n;
  normal = normalized(normal);
  double level = 0;
  for (const int p : outer) level += dot(normal, skin.now[at(p)]) / static_cast<double>(outer.size());
  std::vector<double> out;
  out.reserve(skin.now.size());
  for (const Vec3& p : skin.now) out.push_back(dot(normal, p) - level);
  return out;
}

// Two points of a loop far apart at rest: the farthest one from any, and the farthest one from that, until
// they are each other's.
Edge ends_of(const std::vector<int>& loop, const Skin& skin) {
  const auto farthest_from = [&](int from) {
    return *std::max_element(loop.begin(), loop.end(), [&](int a, int b) {
      return squared_length(skin.rest[at(a)] - skin.rest[at(from)]) <
             squared_length(skin.rest[at(b)] - skin.rest[at(from)]);
    });
  };
  constexpr int most_rounds = 8;
  int one = farthest_from(loop.front()), other = farthest_from(one);
  for (int round = 0; round < most_rounds && farthest_from(other) != one; ++round) {
    one = other;
    other = farthest_from(one);
  }
  return {std::min(one, other), std::max(one, other)};
}

FleshMeasures::DogEar dog_ear(int end, double reach, const Skin& skin, const std::vector<double>& height) {
  FleshMeasures::DogEar ear{skin.now[at(end)], height[at(end)], skin.now[at(end)]};
  for (std::size_t i = 0; i < height.size(); ++i) {
    if (height[i] > ear.height && distance(skin.rest[i], skin.rest[at(end)]) <= reach) {
      ear.height = height[i], ear.at = skin.now[i];
    }
  }
  return ear;
}

void measure_openings(const Flesh& flesh, const Skin& skin, FleshMeasures& m) {
  auto loops = boundary_loops(flesh.surface);
  if (loops.empty()) return;
  const auto outer = std::max_element(loops.begin(), loops.end(), [&](const auto& a, const auto& b) {
    return perimeter(a, skin.rest) < perimeter(b, skin.rest);
  });
  const std::vector<double> height = heights(flesh, skin, *outer);
  const auto highest = std::max_element(height.begin(), height.end());
  m.rise = *highest;
  m.rise_at = skin.now[static_cast<std::size_t>(highest - height.begin())];
  for (auto loop = loops.begin(); loop != loops.end(); ++loop) {
    if (loop == outer) continue;
    m.opening += area(*loop, skin.now);
    m.rest_opening += area(*loop, skin.rest);
    const Edge ends = ends_of(*loop, skin);
    const double reach = 0.5 * distance(skin.rest[at(ends[0])], skin.rest[at(ends[1])]);
    for (const int end : ends) m.dog_ears.push_back(dog_ear(end, reach, skin, height));
  }
}

void measure_thickness(const Flesh& flesh, const std::vector<Vec3>& positions, FleshMeasures& m) {
  m.least_thickness = std::numeric_limits<double>::infinity();
  for (int c = 0; c < flesh.columns(); ++c) {
    const double t =
        distance(positions[at(flesh.sample(0, c))], positions[at(flesh.sample(flesh.layers - 1, c))]);
    m.thickness += t / flesh.columns();
    m.least_thickness = std::min(m.least_thickness, t);
    m.greatest_thickness = std::max(m.greatest_thickness, t);
  }
}

// Length by which a point lies inside; 0 outside.
double depth_in(const Barrier& barrier, const Vec3& point) {
  if (barrier.shape == Barrier::Shape::sphere)
    return std::max(0.0, barrier.radius_mm - distance(point, barrier.centre));
  Barrier probe = barrier;  // whose energy is half the squared depth
  probe.stiffness_n = probe.scale_mm = 1;
  probe.law = SpringLaw::linear;
  probe.clings = false;
  probe.threshold_mm = 0;
  return std::sqrt(2 * respond(probe, point).energy);
}

}  // namespace

std::vector<FleshMeasures> measure(const Specimen& specimen) {
  std::vector<FleshMeasures> out;
  for (const TissueBody& body : specimen.bodies()) {
    if (&body == &specimen.bodies().front() || body.solid) continue;
    FleshMeasures m;
    m.name = body.name;
    m.samples = body.count;
    m.springs = static_cast<int>(body.parts.network.springs.size());
    m.prisms = prism_count(body.flesh);
    const std::vector<Vec3> positions = specimen.positions_of(body);
    m.inverted = inverted_prisms(body.flesh, positions);
    const Skin skin = skin_of(body.flesh, positions);
    for (const Vec3& p : skin.now) m.skin_box.extend(p);
    measure_openings(body.flesh, skin, m);
    measure_thickness(body.flesh, positions, m);
    for (int i = 0; i < body.count; ++i) {
      m.greatest_speed = std::max(m.greatest_speed, length(specimen.state().velocity[at(body.offset + i)]));
    }
    out.push_back(m);
  }
  return out;
}

int inverted_prisms(const Specimen& specimen) {
  int count = 0;
  for (std::size_t b = 1; b < specimen.bodies().size(); ++b) {
    const TissueBody& body = specimen.bodies()[b];
    if (body.solid) continue;
    count += inverted_prisms(body.flesh, specimen.positions_of(body));
  }
  return count;
}

std::vector<Penetration> penetrations(const Specimen& specimen) {
  std::vector<Penetration> out;
  for (const Collision& c : specimen.collisions()) {
    Penetration p{c.object, 0, 0};
    if (c.shape == RegionShape::sphere) p.radius = c.barrier.radius_mm;
    for (std::size_t b = 0; b < specimen.bodies().size(); ++b) {
      if (c.body >= 0 && c.body != static_cast<int>(b)) continue;
      const std::vector<Vec3> x = specimen.positions_of(specimen.bodies()[b]);
      const int columns = std::max(specimen.bodies()[b].flesh.columns(), 1);
      for (int i = 0; i < static_cast<int>(x.size()); ++i) {
        if (c.layer < 0 || i / columns == c.layer) p.depth = std::max(p.depth, depth_in(c.barrier, x[at(i)]));
      }
    }
    out.push_back(p);
  }
  return out;
}

}  // namespace turgor
