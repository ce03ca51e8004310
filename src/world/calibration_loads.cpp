// Regions of a body at rest, and the forces of loads on them.
#include <algorithm>
#include <map>

#include "turgor/core/index.hpp"
#include "world/calibration_parts.hpp"

namespace turgor {
namespace {

/// Lattice points are rounded: a region that ends on a layer of them takes it in.
double margin_of(const SolidMesh& mesh) {
  return 1e-6 * mesh.spacing;
}

Error none_in(const RestRegion& region, const char* what) {
  return {ErrorKind::bad_input, std::string("the region holds ") + what, region.where,
          "Move or enlarge the region; lengths are mm, in the place of the body at rest"};
}

int nearest_of(std::span<const int> points, const SolidMesh& mesh, const Vec3& to) {
  return *std::min_element(points.begin(), points.end(), [&](int a, int b) {
    return distance(mesh.points[at(a)], to) < distance(mesh.points[at(b)], to);
  });
}

/// The corners of the sides of cubes on the surface: two triangles each, (a, b, d) and (c, d, b).
std::vector<std::array<int, 4>> sides_in(const RestRegion& region, const SolidMesh& mesh) {
  std::vector<std::array<int, 4>> sides;
  for (std::size_t t = 0; t + 1 < mesh.surface_triangles.size(); t += 2) {
    const Index3 &first = mesh.surface_triangles[t], &second = mesh.surface_triangles[t + 1];
    const std::array<int, 4> corners{first[0], first[1], second[0], first[2]};
    if (std::ranges::all_of(corners,
                            [&](int p) { return region.contains(mesh.points[at(p)], margin_of(mesh)); }))
      sides.push_back(corners);
  }
  return sides;
}

Result<void> spread_on_sides(const CalibrationForce& force, const SolidMesh& mesh, PreparedLoad& load) {
  const auto sides = sides_in(force.region, mesh);
  if (sides.empty()) return none_in(force.region, "no side of a cube on the surface of the body");
  const double area = mesh.spacing * mesh.spacing;
  for (const auto& side : sides) {
    Vec3 traction = force.vector;
    if (force.kind == CalibrationForce::Kind::pressure) {
      const Vec3& a = mesh.points[at(side[0])];
      const Vec3 outward = cross(mesh.points[at(side[1])] - a, mesh.points[at(side[3])] - a);
      traction = outward * (-force.vector.x / length(outward));
    }
    for (const int p : side) load.force_n[at(p)] += traction * (area / 4);
  }
  return {};
}

Result<void> spread_on_points(const CalibrationForce& force, const SolidMesh& mesh, PreparedLoad& load) {
  TURGOR_TRY(const std::vector<int> points, points_in(force.region, mesh, true));
  for (const int p : points) load.force_n[at(p)] += force.vector / static_cast<double>(points.size());
  return {};
}

Result<void> displace(const CalibrationForce& force, const SolidMesh& mesh, std::span<const int> held,
                      std::map<int, Vec3>& displaced) {
  TURGOR_TRY(const std::vector<int> points, points_in(force.region, mesh, false));
  bool any = false;
  for (const int p : points) {
    if (std::ranges::binary_search(held, p)) continue;
    displaced[p] = force.vector, any = true;
  }
  if (!any) return none_in(force.region, "only points that are held");
  return {};
}

}  // namespace

bool RestRegion::contains(const Vec3& p, double margin_mm) const {
  if (box) {
    for (int a = 0; a < 3; ++a)
      if (p[a] < box->lower[a] - margin_mm || p[a] > box->upper[a] + margin_mm) return false;
  }
  if (centre && distance(p, *centre) > radius_mm + margin_mm) return false;
  return !beyond || beyond->signed_distance(p) >= -margin_mm;
}

Result<std::vector<int>> points_in(const RestRegion& region, const SolidMesh& mesh, bool surface_only) {
  std::vector<int> points;
  for (std::size_t p = 0; p < mesh.points.size(); ++p) {
    if (surface_only && mesh.on_surface[p] == 0) continue;
    if (region.contains(mesh.points[p], margin_of(mesh))) points.push_back(static_cast<int>(p));
  }
  if (points.empty()) return none_in(region, "no points of the body");
  if (region.nearest) return std::vector<int>{nearest_of(points, mesh, *region.nearest)};
  return points;
}

Result<std::vector<char>> cubes_in(const RestRegion& region, const SolidMesh& mesh) {
  const auto cubes = hexahedra(mesh);
  std::vector<char> in(cubes.size());
  for (std::size_t c = 0; c < cubes.size(); ++c) {
    const Vec3 centre = (mesh.points[at(cubes[c][0])] + mesh.points[at(cubes[c][6])]) * 0.5;
    in[c] = region.contains(centre, margin_of(mesh)) ? 1 : 0;
  }
  if (std::ranges::find(in, 1) == in.end()) return none_in(region, "no centre of a cube of the body");
  return in;
}

Result<PreparedLoad> place_load(const CalibrationLoad& load, const SolidMesh& mesh,
                                std::span<const int> held) {
  if (load.forces.empty()) {
    return Error{ErrorKind::bad_input, "the load '" + load.name + "' has no force", load.where,
                 "Let force, traction or displace follow it"};
  }
  PreparedLoad out;
  out.name = load.name, out.held_out = load.held_out;
  out.force_n.resize(mesh.points.size());
  std::map<int, Vec3> displaced;
  for (const CalibrationForce& force : load.forces) {
    switch (force.kind) {
      case CalibrationForce::Kind::force:
        TURGOR_CHECK(spread_on_points(force, mesh, out));
        break;
      case CalibrationForce::Kind::traction:
      case CalibrationForce::Kind::pressure:
        TURGOR_CHECK(spread_on_sides(force, mesh, out));
        break;
      case CalibrationForce::Kind::displacement:
        TURGOR_CHECK(displace(force, mesh, held, displaced));
        break;
    }
  }
  for (const auto& [point, by] : displaced) out.displaced.push_back({.node = point, .displacement_mm = by});
  return out;
}

ElasticSupports supports_of(std::span<const int> held, const PreparedLoad& load) {
  ElasticSupports supports{load.displaced, {}};
  for (const int p : held) supports.nodes.push_back({.node = p});
  return supports;
}

ElasticLoad elastic_load(const PreparedLoad& load) {
  ElasticLoad out;
  for (std::size_t p = 0; p < load.force_n.size(); ++p)
    if (!(load.force_n[p] == Vec3{})) out.forces.push_back({static_cast<int>(p), load.force_n[p]});
  return out;
}

NetworkLoad network_load(const PreparedLoad& load, const SolidMesh& mesh, std::span<const int> held) {
  NetworkLoad out;
  out.name = load.name;
  out.motion.fixed.assign(held.begin(), held.end());
  for (const NodeSupport& s : load.displaced) {
    out.motion.moved.push_back(s.node);
    out.motion.positions.push_back(mesh.points[at(s.node)] + s.displacement_mm);
  }
  out.loads.force_n = load.force_n;
  return out;
}

}  // namespace turgor
