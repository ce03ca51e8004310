#include "dynamics/point_clusters.hpp"

#include <numeric>

#include "tissue/incidence.hpp"

namespace turgor {
namespace {

// Disjoint sets of points of bounded size.
class BoundedSets {
 public:
  BoundedSets(int points, int largest)
      : parent_(static_cast<std::size_t>(points)),
        size_(static_cast<std::size_t>(points), 1),
        largest_(largest) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int root(int p) {
    while (parent_[p] != p) p = parent_[p] = parent_[parent_[p]];
    return p;
  }
  [[nodiscard]] bool alone(int p) { return size_[root(p)] == 1; }
  void unite(int a, int b) {
    a = root(a), b = root(b);
    if (a == b || size_[a] + size_[b] > largest_) return;
    parent_[b] = a;
    size_[a] += size_[b];
  }

 private:
  std::vector<int> parent_, size_;
  int largest_;
};

std::vector<char> free_points(int point_count, const PrescribedMotion& motion) {
  std::vector<char> is_free(static_cast<std::size_t>(point_count), 1);
  for (const int p : motion.moved) is_free[p] = 0;
  for (const int p : motion.fixed) is_free[p] = 0;
  return is_free;
}

}  // namespace

PointClusters cluster_free_points(const SpringNetwork& network, const NetworkEnergy& energy,
                                  const PrescribedMotion& motion, int largest) {
  const int n = energy.point_count();
  const std::vector<char> is_free = free_points(n, motion);
  BoundedSets sets(n, largest);
  for (const Spring& s : network.springs) {
    if (s.kind == SpringKind::vertical && is_free[s.a] && is_free[s.b]) sets.unite(s.a, s.b);
  }
  std::vector<char> lone(static_cast<std::size_t>(n));
  for (int p = 0; p < n; ++p) lone[p] = is_free[p] && sets.alone(p);
  for (const Spring& s : network.springs) {
    if (lone[s.a] && lone[s.b]) sets.unite(s.a, s.b);
  }
  for (const Solid& solid : network.solids) {
    for (const auto& [a, b] : solid.edges) {
      if (lone[a] && lone[b]) sets.unite(a, b);
    }
  }

  std::vector<std::vector<int>> members(static_cast<std::size_t>(n));
  for (int p = 0; p < n; ++p) {
    if (is_free[p]) members[sets.root(p)].push_back(p);
  }
  PointClusters clusters;
  std::vector<char> taken(static_cast<std::size_t>(n), 0);
  const auto take = [&](int p) {
    if (!is_free[p] || taken[sets.root(p)]) return;
    taken[sets.root(p)] = 1;
    clusters.offsets.push_back(static_cast<int>(clusters.points.size()));
    clusters.points.insert(clusters.points.end(), members[sets.root(p)].begin(), members[sets.root(p)].end());
  };
  std::size_t done = 0;
  for (int seed = 0; seed < n; ++seed) {
    take(seed);
    for (; done < clusters.points.size(); ++done) visit_neighbours(energy, clusters.points[done], take);
  }
  clusters.offsets.push_back(static_cast<int>(clusters.points.size()));
  return clusters;
}

}  // namespace turgor
