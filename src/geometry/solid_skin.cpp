#include "turgor/geometry/solid_skin.hpp"
#include "turgor/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "geometry/connectivity.hpp"
#include "geometry/length_check.hpp"
#include "geometry/nearest_points.hpp"
#include "geometry/surface_frames.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

using detail::Frame, detail::NearPoint, detail::SurfaceFrames;

constexpr std::size_t grain = 2048;
/// Squared: sums of unit normals below it are rounding.
constexpr double cancelled = 1e-10;

/// Weight times offset in a frame, and the weight: p = Σ frame · vote.
using Vote = std::array<float, 4>;

/// Weight times the normal in a frame.
using Direction = std::array<float, 3>;

Vec3 sum_of_votes(std::span<const Vote> votes, std::span<const int> voters, const Frame* frames) {
  Lanes sum{};
  for (std::size_t j = 0; j < votes.size(); ++j) {
    const auto& [x, y, z, o] = frames[voters[j]].columns;
    const Vote& v = votes[j];
    sum += (x * double{v[0]} + y * double{v[1]}) + (z * double{v[2]} + o * double{v[3]});
  }
  return {sum[0], sum[1], sum[2]};
}

/// The same without the places; zero where opposite frames cancel.
Vec3 sum_of_directions(std::span<const Direction> directions, std::span<const int> voters,
                       const Frame* frames) {
  Lanes sum{};
  for (std::size_t j = 0; j < directions.size(); ++j) {
    const auto& [x, y, z, o] = frames[voters[j]].columns;
    const Direction& d = directions[j];
    sum += (x * double{d[0]} + y * double{d[1]}) + z * double{d[2]};
  }
  return {sum[0], sum[1], sum[2]};
}

Vote vote_of(const Frame& frame, const Vec3& weighted, double weight) {
  return {static_cast<float>(dot(frame.column(0), weighted)),
          static_cast<float>(dot(frame.column(1), weighted)),
          static_cast<float>(dot(frame.column(2), weighted)), static_cast<float>(weight)};
}

/// Inverse squared distances that add up to 1: all of it to the first if it has none.
void weigh(std::span<const NearPoint> near, std::span<double> weights) {
  const double first = near[0].squared_distance;
  double sum = 0;
  for (std::size_t j = 0; j < near.size(); ++j) {
    weights[j] = j == 0 ? 1 : first > 0 ? first / near[j].squared_distance : 0;
    sum += weights[j];
  }
  for (double& w : weights) w /= sum;
}

struct Bindings {
  std::size_t neighbours = 0;         ///< of each point
  std::vector<Vote> votes;            ///< one each, and one more a point: see cast_votes
  std::vector<int> voters;            ///< the frame of each vote; a point's nearest first
  std::vector<Direction> directions;  ///< one a neighbour

  [[nodiscard]] std::size_t size() const { return directions.size() / neighbours; }
};

template <class List>
auto part_of(List& list, std::size_t i, std::size_t count) {
  return std::span(list).subspan(i * count, count);
}

/// One vote a neighbour, and one more of the nearest for what rounding to single precision left of place and
/// weight: so rest and rigid motions, where all frames agree, are exact to double precision.
void cast_votes(std::size_t i, const Vec3& place, const Vec3& normal, std::span<const NearPoint> near,
                std::span<const Frame> rest, Bindings& bindings) {
  std::array<double, SolidSkin::kMostNeighbours> weights{};
  weigh(near, weights);
  const auto votes = part_of(bindings.votes, i, bindings.neighbours + 1);
  const auto voters = part_of(bindings.voters, i, bindings.neighbours + 1);
  const auto directions = part_of(bindings.directions, i, bindings.neighbours);
  double left = 1;
  for (std::size_t j = 0; j < near.size(); ++j) {
    const Frame& frame = rest[at(near[j].point)];
    voters[j] = near[j].point;
    votes[j] = vote_of(frame, (place - frame.column(3)) * weights[j], weights[j]);
    left -= static_cast<double>(votes[j][3]);
    const Vote direction = vote_of(frame, normal * weights[j], 0);
    directions[j] = {direction[0], direction[1], direction[2]};
  }
  const Frame& nearest = rest[at(near[0].point)];
  voters[near.size()] = near[0].point;
  votes[near.size()] = {0, 0, 0, static_cast<float>(left)};
  votes[near.size()] = vote_of(nearest, place - sum_of_votes(votes, voters, rest.data()), left);
}

Result<void> check(const SolidMesh& solid, const TriMesh& skin, int neighbours) {
  TURGOR_CHECK(validate(skin));
  TURGOR_CHECK(detail::check_lengths(skin.points, "point of the skin"));
  TURGOR_CHECK(detail::check_lengths(solid.points, "point of the solid"));
  if (neighbours < 1 || neighbours > SolidSkin::kMostNeighbours) {
    return Error{ErrorKind::bad_input, fmt::format("{} neighbours cannot be used", neighbours), "",
                 fmt::format("Give 1 to {}", SolidSkin::kMostNeighbours)};
  }
  for (const Index3& t : solid.surface_triangles) {
    for (const int p : t) {
      if (p >= 0 && at(p) < solid.points.size()) continue;
      return Error{ErrorKind::bad_input,
                   fmt::format("the solid's surface names point {} of {}", p, solid.points.size()), "",
                   "Repair the solid"};
    }
  }
  return {};
}

/// Frames at every point of the solid's surface, points ascending.
SurfaceFrames surface_frames(const SolidMesh& solid) {
  const std::vector<Index3> triangles(solid.surface_triangles.begin(), solid.surface_triangles.end());
  const detail::Lists corners = detail::corners_by_point(solid.points.size(), triangles);
  SurfaceFrames frames;
  std::vector<std::array<int, 2>> rims;
  for (std::size_t p = 0; p < corners.size(); ++p) {
    rims.clear();
    for (const int corner : corners[p]) {
      rims.push_back({detail::corner_point(triangles, detail::next_corner(corner)),
                      detail::corner_point(triangles, detail::previous_corner(corner))});
    }
    frames.add(static_cast<int>(p), rims, solid.points);
  }
  return frames;
}

/// Renumbers `voters` to those frames that are used, which are returned.
SurfaceFrames used_frames(const SurfaceFrames& all, std::vector<int>& voters) {
  std::vector<int> number(all.size(), -1), used;
  for (const int voter : voters) number[at(voter)] = 0;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (number[i] < 0) continue;
    number[i] = static_cast<int>(used.size());
    used.push_back(static_cast<int>(i));
  }
  for (int& voter : voters) voter = number[at(voter)];
  return all.chosen(used);
}

}  // namespace

struct SolidSkin::Bound {
  SurfaceFrames frames;
  Bindings bindings;
};

SolidSkin::SolidSkin(std::shared_ptr<const Bound> bound) : bound_(std::move(bound)) {}

Result<SolidSkin> SolidSkin::bind(const SolidMesh& solid, const TriMesh& skin, int neighbours) {
  TURGOR_CHECK(check(solid, skin, neighbours));
  const SurfaceFrames all = surface_frames(solid);
  if (all.size() == 0)
    return Error{ErrorKind::bad_input, "the solid has no surface", "", "Give a solid to follow"};
  std::vector<Vec3> places(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) places[i] = solid.points[at(all.point(i))];
  std::vector<Frame> rest(all.size());
  all.compute(solid.points, rest);
  const detail::NearestPoints tree(std::move(places));
  const std::vector<Vec3> normals = point_normals(skin);
  Bindings bindings{std::min(at(neighbours), all.size()), {}, {}, {}};
  bindings.directions.resize(skin.points.size() * bindings.neighbours);
  bindings.votes.resize(bindings.directions.size() + skin.points.size());
  bindings.voters.resize(bindings.votes.size());
  parallel_for(skin.points.size(), grain, [&](std::size_t begin, std::size_t end) {
    std::vector<NearPoint> near(bindings.neighbours);
    for (std::size_t i = begin; i < end; ++i) {
      tree.find(skin.points[i], near);
      cast_votes(i, skin.points[i], normals[i], near, rest, bindings);
    }
  });
  SurfaceFrames frames = used_frames(all, bindings.voters);
  return SolidSkin(std::make_shared<const Bound>(Bound{std::move(frames), std::move(bindings)}));
}

std::size_t SolidSkin::point_count() const {
  return bound_->bindings.size();
}

void SolidSkin::apply(std::span<const Vec3> solid_positions, std::span<Vec3> positions,
                      std::span<Vec3> normals) const {
  const SurfaceFrames& frames = bound_->frames;
  const Bindings& bindings = bound_->bindings;
  const auto now = std::make_unique_for_overwrite<Frame[]>(frames.size());
  frames.compute(solid_positions, {now.get(), frames.size()});
  parallel_for(bindings.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto voters = part_of(bindings.voters, i, bindings.neighbours + 1);
      positions[i] = sum_of_votes(part_of(bindings.votes, i, bindings.neighbours + 1), voters, now.get());
      if (normals.empty()) continue;
      const Vec3 sum =
          sum_of_directions(part_of(bindings.directions, i, bindings.neighbours), voters, now.get());
      const double squared = squared_length(sum);
      normals[i] = squared > cancelled ? sum * (1 / std::sqrt(squared)) : now[at(voters[0])].column(0);
    }
  });
}

Result<SkinDifference> difference(const TriMesh& a, const TriMesh& b) {
  for (const TriMesh* mesh : {&a, &b}) {
    TURGOR_CHECK(validate(*mesh));
    TURGOR_CHECK(detail::check_lengths(mesh->points, "point"));
  }
  const std::size_t count = a.points.size();
  if (count != b.points.size() || count == 0) {
    return Error{ErrorKind::bad_input,
                 fmt::format("surfaces of {} and {} points cannot be compared", count, b.points.size()), "",
                 "Give the same surface, carried two ways"};
  }
  SkinDifference result;
  const auto normals_a = point_normals(a), normals_b = point_normals(b);
  double sum = 0, squares = 0, angles = 0, compared = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double d = distance(a.points[i], b.points[i]);
    sum += d, squares += d * d;
    if (d > result.greatest_mm) result.greatest_mm = d, result.greatest_at = static_cast<int>(i);
    if (normals_a[i] == Vec3{} || normals_b[i] == Vec3{}) continue;
    angles += std::atan2(length(cross(normals_a[i], normals_b[i])), dot(normals_a[i], normals_b[i]));
    compared += 1;
  }
  result.mean_mm = sum / static_cast<double>(count);
  result.root_mean_square_mm = std::sqrt(squares / static_cast<double>(count));
  if (compared > 0) result.mean_normal_angle_deg = degrees(angles / compared);
  return result;
}

}  // namespace turgor
