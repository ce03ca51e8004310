#include "turgor/geometry/solid_remesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

using Tetra = std::array<int, 4>;

Error bad(std::string what, std::string where, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), std::move(where), std::move(remedy)};
}

Mat3 edges(std::span<const Vec3> points, const Tetra& t) {
  const Vec3& a = points[at(t[0])];
  return {{points[at(t[1])] - a, points[at(t[2])] - a, points[at(t[3])] - a}};
}

/// Six volumes by the cube of the longest edge.
double shape(std::span<const Vec3> points, const Tetra& t) {
  double longest = 0;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < i; ++j)
      longest = std::max(longest, squared_length(points[at(t[i])] - points[at(t[j])]));
  const double volumes = edges(points, t).determinant();
  return longest > 0 ? volumes / (longest * std::sqrt(longest)) : 0;
}

/// Which tetrahedra each point belongs to.
struct Incidence {
  std::vector<int> begin, cells;
  Incidence(std::size_t points, std::span<const Tetra> tetrahedra) : begin(points + 1) {
    for (const Tetra& t : tetrahedra)
      for (const int p : t) ++begin[at(p) + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    cells.resize(at(begin.back()));
    std::vector<int> next(begin.begin(), begin.end() - 1);
    for (std::size_t t = 0; t < tetrahedra.size(); ++t)
      for (const int p : tetrahedra[t]) cells[at(next[at(p)]++)] = static_cast<int>(t);
  }
};

/// Smooths rest positions until no tetrahedron is turned over or too flat.
class Repair {
 public:
  /// `back`: for each point the linear map from now to rest in the old tetrahedron that it hangs on.
  Repair(std::span<const Tetra> tetrahedra, std::span<const Vec3> now, const std::vector<Mat3>& back,
         std::span<Vec3> rest)
      : tetrahedra_(tetrahedra), now_(now), back_(back), rest_(rest), moving_(rest.size()) {}

  /// The number of points moved. Error where tetrahedra stay bad.
  Result<int> operator()(int sweeps) {
    std::vector<int> bad_cells = find_bad();
    if (bad_cells.empty()) return 0;
    const Incidence incidence(rest_.size(), tetrahedra_);
    for (int sweep = 0; sweep < sweeps && !bad_cells.empty(); ++sweep) {
      for (const int t : bad_cells)
        for (const int p : tetrahedra_[at(t)]) moving_[at(p)] = 1;
      smooth(incidence);
      bad_cells = find_bad();
    }
    if (bad_cells.empty()) return static_cast<int>(std::count(moving_.begin(), moving_.end(), 1));
    const Vec3& place = rest_[at(tetrahedra_[at(bad_cells[0])][0])];
    return bad(
        fmt::format("{} tetrahedra of the new solid are turned over or flat at rest", bad_cells.size()),
        fmt::format("about ({:.4g}, {:.4g}, {:.4g}) mm", place.x, place.y, place.z),
        "Remesh before the body deforms so far, or at a lower resolution");
  }

 private:
  [[nodiscard]] std::vector<int> find_bad() const {
    return parallel_reduce<std::vector<int>>(
        tetrahedra_.size(), 8192, {},
        [&](std::size_t begin, std::size_t end) {
          std::vector<int> found;
          for (std::size_t t = begin; t < end; ++t)
            if (!(shape(rest_, tetrahedra_[t]) >= RemeshOptions::least_shape))
              found.push_back(static_cast<int>(t));
          return found;
        },
        [](std::vector<int> all, const std::vector<int>& part) {
          all.insert(all.end(), part.begin(), part.end());
          return all;
        });
  }
  /// Each moving point to the mean of what those it shares tetrahedra with say of it and of its own map.
  void smooth(const Incidence& incidence) {
    std::vector<Vec3> moved(rest_.begin(), rest_.end());
    std::vector<Mat3> blended = back_;
    parallel_for(rest_.size(), 1024, [&](std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p)
        if (moving_[p] != 0) smooth_point(p, incidence, moved[p], blended[p]);
    });
    std::copy(moved.begin(), moved.end(), rest_.begin());
    back_ = std::move(blended);
  }
  void smooth_point(std::size_t p, const Incidence& incidence, Vec3& place, Mat3& map) const {
    Vec3 sum;
    Mat3 maps{{Vec3{}, Vec3{}, Vec3{}}};
    double count = 0;
    for (int n = incidence.begin[p]; n < incidence.begin[p + 1]; ++n) {
      for (const int q : tetrahedra_[at(incidence.cells[at(n)])]) {
        if (at(q) == p) continue;
        sum += rest_[at(q)] + back_[at(q)] * (now_[p] - now_[at(q)]);
        for (std::size_t c = 0; c < 3; ++c) maps.c[c] += back_[at(q)].c[c];
        count += 1;
      }
    }
    place = sum / count;
    for (std::size_t c = 0; c < 3; ++c) map.c[c] = maps.c[c] / count;
  }

  std::span<const Tetra> tetrahedra_;
  std::span<const Vec3> now_;
  std::vector<Mat3> back_;
  std::span<Vec3> rest_;
  std::vector<std::uint8_t> moving_;
};

/// From now to rest, in the old tetrahedron of each place.
std::vector<Mat3> maps_back(const RemeshSnapshot& s, const TetraEmbedding& embedding) {
  std::vector<Mat3> back(embedding.corners().size());
  parallel_for(back.size(), 2048, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const Tetra& t = embedding.corners()[p];
      back[p] = edges(s.rest, t) * edges(s.positions, t).inverse();
    }
  });
  return back;
}

Result<void> check(const RemeshSnapshot& s) {
  if (s.rest.size() != s.positions.size()) {
    return bad(fmt::format("{} points at rest cannot stand at {} places", s.rest.size(), s.positions.size()),
               "", "Give both of the same solid");
  }
  const auto finite = [](const Vec3& p) { return is_finite(p); };
  if (!std::all_of(s.rest.begin(), s.rest.end(), finite))
    return bad("a point of the old solid is not finite at rest", "", "Repair the solid");
  return {};
}

}  // namespace

Result<RemeshedSolid> remesh_solid(const RemeshSnapshot& snapshot, const RemeshOptions& options,
                                   const Context& context) {
  TURGOR_CHECK(check(snapshot));
  TURGOR_TRY(const VoxelGrid voxels, voxelise(snapshot.skin, options.voxels, context));
  TURGOR_CHECK(context.check());
  RemeshedSolid out;
  TURGOR_TRY(out.solid, solid_of(voxels));
  out.solid.spacing = 0;
  out.positions.assign(out.solid.points.begin(), out.solid.points.end());
  TURGOR_CHECK(context.check());
  TURGOR_TRY(out.from_old, TetraEmbedding::bind(snapshot.positions, snapshot.tetrahedra, out.positions));
  TURGOR_CHECK(context.check());
  out.from_old.apply(snapshot.rest, out.solid.points);
  out.greatest_outside_mm = 0;
  for (const TetraEmbedding::Place& place : out.from_old.places())
    out.greatest_outside_mm = std::max(out.greatest_outside_mm, place.outside_mm);
  Repair repair(out.solid.tetrahedra, out.positions, maps_back(snapshot, out.from_old), out.solid.points);
  TURGOR_TRY(out.repaired, repair(options.repair_sweeps));
  TURGOR_CHECK(context.check());
  return out;
}

}  // namespace turgor
