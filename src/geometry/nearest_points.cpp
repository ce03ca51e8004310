#include "geometry/nearest_points.hpp"

#include <array>
#include <cstddef>
#include <limits>
#include <nanoflann.hpp>
#include <utility>

namespace turgor::detail {
namespace {

/// What nanoflann asks of a set of points.
struct PointSet {
  std::vector<Vec3> points;
  [[nodiscard]] std::size_t kdtree_get_point_count() const { return points.size(); }
  [[nodiscard]] double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points[i][static_cast<int>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

/// The best so far, ascending. Unlike nanoflann's own, of equally far points it takes the lower number, also
/// for the last place.
class Best {
 public:
  explicit Best(std::span<NearPoint> found) : found_(found) {}
  [[nodiscard]] std::size_t size() const { return count_; }
  [[nodiscard]] bool full() const { return count_ == found_.size(); }
  [[nodiscard]] double worstDist() const {
    // A little more, so that rounding of the tree's own bounds hides nothing equally far.
    return full() ? found_.back().squared_distance * (1 + 1e-12) + std::numeric_limits<double>::denorm_min()
                  : std::numeric_limits<double>::max();
  }
  bool addPoint(double squared_distance, std::size_t index) {
    const NearPoint point{squared_distance, static_cast<int>(index)};
    if (full() && !(point < found_.back())) return true;
    if (!full()) ++count_;
    std::size_t i = count_ - 1;
    for (; i > 0 && point < found_[i - 1]; --i) found_[i] = found_[i - 1];
    found_[i] = point;
    return true;
  }

 private:
  std::span<NearPoint> found_;
  std::size_t count_ = 0;
};

}  // namespace

struct NearestPoints::Tree {
  using Metric = nanoflann::L2_Simple_Adaptor<double, PointSet, double, std::size_t>;

  explicit Tree(std::vector<Vec3> points) : set{std::move(points)}, index(3, set) {}

  PointSet set;
  nanoflann::KDTreeSingleIndexAdaptor<Metric, PointSet, 3, std::size_t> index;
};

NearestPoints::NearestPoints(std::vector<Vec3> points) : tree_(std::make_unique<Tree>(std::move(points))) {}
NearestPoints::~NearestPoints() = default;

void NearestPoints::find(const Vec3& at, std::span<NearPoint> found) const {
  Best best(found);
  const std::array<double, 3> query{at.x, at.y, at.z};
  tree_->index.findNeighbors(best, query.data(), nanoflann::SearchParams());
}

}  // namespace turgor::detail
