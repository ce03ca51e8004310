#include "world/face_skin.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

/// The nodes of a lattice by place.
class NodeTable {
 public:
  explicit NodeTable(const SolidMesh& mesh) : spacing_(mesh.spacing) {
    Box3 box;
    for (const Vec3& p : mesh.points) box.extend(p);
    lower_ = box.lower;
    for (int a = 0; a < 3; ++a) size_[at(a)] = static_cast<int>(std::lround(box.size()[a] / spacing_)) + 1;
    nodes_.assign(at(size_[0]) * at(size_[1]) * at(size_[2]), -1);
    for (std::size_t n = 0; n < mesh.points.size(); ++n) {
      Index3 p{};
      for (int a = 0; a < 3; ++a)
        p[at(a)] = static_cast<int>(std::lround((mesh.points[n] - lower_)[a] / spacing_));
      nodes_[index(p[0], p[1], p[2])] = static_cast<int>(n);
    }
  }
  /// Calls visit(node) for those within a cube about a point.
  template <class Visit>
  void near(const Vec3& point, double reach, Visit visit) const {
    Index3 low{}, high{};
    for (int a = 0; a < 3; ++a) {
      const double place = (point - lower_)[a] / spacing_, way = reach / spacing_;
      low[at(a)] = std::max(0, static_cast<int>(std::ceil(place - way)));
      high[at(a)] = std::min(size_[at(a)] - 1, static_cast<int>(std::floor(place + way)));
    }
    for (int k = low[2]; k <= high[2]; ++k)
      for (int j = low[1]; j <= high[1]; ++j)
        for (int i = low[0]; i <= high[0]; ++i)
          if (const int node = nodes_[index(i, j, k)]; node >= 0) visit(node);
  }

 private:
  [[nodiscard]] std::size_t index(int i, int j, int k) const {
    return (at(k) * at(size_[1]) + at(j)) * at(size_[0]) + at(i);
  }
  double spacing_;
  Vec3 lower_;
  Index3 size_{};
  std::vector<int> nodes_;
};

/// +1 / -1: of the upper / lower lip; 0: of neither.
int side_of(const std::optional<LipSlit>& slit, const Vec3& p) {
  if (!slit || !slit->covers(p)) return 0;
  return slit->plane.signed_distance(p) > 0 ? 1 : -1;
}

/// How much a point of one lip sees of the other: all at the corners of the mouth, where lips are one,
/// nothing from `fade_mm` on.
double share_of_other_lip(const std::optional<LipSlit>& slit, const Vec3& p, double fade_mm) {
  if (!slit) return 1;
  const Vec3 across = normalized(slit->left - slit->right);
  const double inside = std::min(dot(p - slit->right, across), dot(slit->left - p, across));
  const double share = std::clamp(1 - inside / fade_mm, 0.0, 1.0);
  return share * share;
}

/// A linear field fitted to weighted values, about a point; its slope is held back where too few points, or
/// points in a plane, do not say it.
class LinearFit {
 public:
  explicit LinearFit(double scale) : scale_(scale) {}
  void add(const Vec3& offset, double weight, const Vec3& value) {
    const std::array<double, 4> basis{1, offset.x / scale_, offset.y / scale_, offset.z / scale_};
    for (std::size_t r = 0; r < 4; ++r) {
      for (std::size_t c = 0; c < 4; ++c) a_[r][c] += weight * basis[r] * basis[c];
      b_[r] += value * (weight * basis[r]);
    }
  }
  [[nodiscard]] bool empty() const { return !(a_[0][0] > 0); }
  /// At the point itself.
  [[nodiscard]] Vec3 value() const {
    auto a = a_;
    auto b = b_;
    constexpr double hold = 0.05;
    for (std::size_t r = 1; r < 4; ++r) a[r][r] += hold * a_[0][0];
    // The value comes last, so that no back substitution is needed.
    for (std::size_t p = 3; p > 0; --p) {
      for (std::size_t r = 0; r < p; ++r) {
        const double factor = a[r][p] / a[p][p];
        for (std::size_t c = 0; c <= p; ++c) a[r][c] -= factor * a[p][c];
        b[r] -= b[p] * factor;
      }
    }
    return b[0] / a[0][0];
  }

 private:
  double scale_;
  std::array<std::array<double, 4>, 4> a_{};
  std::array<Vec3, 4> b_{};
};

}  // namespace

std::vector<Vec3> carry_skin(const FaceSolid& face, const LayeredTissue& tissue,
                             std::span<const Vec3> displacement_mm) {
  // Skin over bone nearer than half a cube has no cube of its own: the reach grows until some are found.
  constexpr double least_reach = 2.2, greatest_reach = 7.0, corner_cubes = 2.0;
  const double spacing = face.mesh.spacing;
  const NodeTable table(face.mesh);
  std::vector<Vec3> out(at(tissue.columns()));
  parallel_for(out.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      if (tissue.fixed[c]) continue;
      const Vec3& place = tissue.surface.points[c];
      const double other_lip = share_of_other_lip(tissue.slit, place, corner_cubes * spacing);
      const int side = tissue.lip_side[c] != 0 ? tissue.lip_side[c] : side_of(tissue.slit, place);
      for (double reach = least_reach * spacing; reach <= greatest_reach * spacing; reach *= 1.7) {
        LinearFit fit(spacing);
        table.near(place, reach, [&](int node) {
          const Vec3& p = face.mesh.points[at(node)];
          const double share = 1 - squared_length(p - place) / (reach * reach);
          if (share <= 0) return;
          const bool across = side * side_of(tissue.slit, p) < 0;
          const double weight = share * share * (across ? other_lip : 1);
          if (weight > 0) fit.add(p - place, weight, displacement_mm[at(node)]);
        });
        if (fit.empty()) continue;
        out[c] = fit.value();
        break;
      }
    }
  });
  return out;
}

}  // namespace turgor
