// A multigrid cycle on lattices of cubes: an approximate inverse of the stiffness of those components that
// are not held, symmetric and positive, the same for every vector. Internal.
#pragma once

#include <memory>
#include <vector>

#include "fem/voxel_level.hpp"
#include "turgor/core/context.hpp"

namespace turgor::detail {

/// Steps of the finest level, before and after; and how many times as many the first coarse one takes.
struct Smoothing {
  int steps = 4, first_factor = 3;
};

class VoxelMultigrid {
 public:
  /// `finest`: finished. `held`: of each of its values.
  static Result<VoxelMultigrid> build(std::unique_ptr<VoxelLevel> finest,
                                      const std::vector<std::uint8_t>& held, Smoothing smoothing,
                                      const Context& context);
  VoxelMultigrid(VoxelMultigrid&&) noexcept;
  VoxelMultigrid& operator=(VoxelMultigrid&&) noexcept;
  ~VoxelMultigrid();

  /// The vectors of one solution under way.
  class Work {
   public:
    explicit Work(const VoxelMultigrid& multigrid);
    /// Of the finest level: to be set before a cycle, destroyed by it; and what comes of it.
    [[nodiscard]] std::vector<float>& residual() { return levels_.front().residual; }
    [[nodiscard]] const std::vector<float>& result() const { return levels_.front().result; }
    /// Of the finest level's nodes, by rising value; at first those that the cycle was built with. Few may
    /// differ from them.
    [[nodiscard]] std::vector<NodePlane>& planes() { return planes_; }

   private:
    friend class VoxelMultigrid;
    struct Vectors {
      std::vector<float> residual, result, step, image;
    };
    std::vector<Vectors> levels_;
    std::vector<NodePlane> planes_;
  };
  /// Of what planes hold neither residual nor result has anything, unless there is one level alone, which is
  /// solved as it is.
  void cycle(Work& work) const { cycle(work, 0); }
  [[nodiscard]] const VoxelLevel& level(std::size_t number) const { return *levels_[number]; }
  [[nodiscard]] std::size_t level_count() const { return levels_.size(); }

 private:
  struct Coarsest;
  VoxelMultigrid();
  void cycle(Work& work, std::size_t number) const;
  [[nodiscard]] int steps_of(std::size_t number) const;
  void smooth(std::size_t number, std::span<const NodePlane> planes, Work::Vectors& v, bool from_zero) const;
  bool factor_coarsest();

  std::vector<std::unique_ptr<VoxelLevel>> levels_;
  std::unique_ptr<Coarsest> coarsest_;
  Smoothing smoothing_;
};

}  // namespace turgor::detail
