// Solids cut into blocks of near tetrahedra, or cubes of a lattice, with points of their own numbering: each
// element's force is computed once, in the cache, and summed over the block; then every point gathers the
// sums of its few blocks in a fixed order.
//
//     block:  points | cubes of pattern 0 | cubes of pattern 1        points
//             points | tetrahedra                              ─►     F = Σ blocks
//
// An element that several tetrahedra share is shared out to them by their volume at rest: energies add up to
// its own. With constants that are the same for a volume everywhere the shares of a lattice's cubes are all
// the same, and none need be read. Blocks depend on the model alone: the same bits on any number of threads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "math/float_lanes.hpp"
#include "turgor/dynamics/time_stepper.hpp"

namespace turgor {

class SolidBlocks {
 public:
  using Workspace = TimeStepper::Workspace;

  explicit SolidBlocks(const MotionModel& model);

  [[nodiscard]] bool empty() const { return blocks_.empty(); }
  /// A solid with an edge or triangle that no tetrahedron has, so that it could not act; −1: none.
  [[nodiscard]] int stray() const { return stray_; }
  /// Solids that are taken for lattices.
  [[nodiscard]] int lattices() const { return lattices_; }

  /// Computes all forces into the workspace; returns a bound of the square of the highest frequency, 1/ms².
  double sum(std::span<const Vec3> position, Workspace& w) const;
  /// The same with lanes of a kind: Floats, Lanes (in double precision) or their scalar twins.
  template <class Real, class Quad>
  double sum_as(std::span<const Vec3> position, std::vector<Quad>& force) const;

  /// Of the workspace after sum(): the force on one point, N.
  class Reader {
   public:
    Vec3 operator()(int point) const {
      return exact_ != nullptr ? total(point, exact_) : total(point, single_);
    }

   private:
    friend class SolidBlocks;
    template <class Quad>
    Vec3 total(int point, const Quad* force) const {
      const int *k = entries_ + offsets_[point], *const end = entries_ + offsets_[point + 1];
      Lanes sum = {};
      for (; k < end; ++k) sum += load_as_lanes(force[*k].v);
      return {sum[0], sum[1], sum[2]};
    }
    const int *offsets_ = nullptr, *entries_ = nullptr;
    const Workspace::QuadOf<float>* single_ = nullptr;
    const Workspace::Quad* exact_ = nullptr;
  };
  [[nodiscard]] Reader reader(const Workspace& w) const;

 private:
  struct Draft;
  enum class Kind : std::uint8_t { tetrahedra, cubes, alike_cubes };
  struct Block {
    Kind kind;
    std::size_t first_member, members;
    std::size_t first_corner;    ///< of the first group of eight
    std::size_t first_constant;  ///< likewise; the solid's where its cubes are alike
    std::size_t groups[2];       ///< of each pattern; tetrahedra have one
    double size_mm;              ///< unit of lengths
    double fastest_square;       ///< bound of ω² at rest, 1/ms²
    std::array<int, 3> corner;   ///< points far apart, which tell how the block has turned
  };

  void prepare_cubes(Draft& draft);
  void lay_out(Draft& draft);
  void lay_out_block(Draft& draft, std::span<const int> piece);
  void lay_out_group(const Draft& draft, std::span<const int, 8> slots);
  [[nodiscard]] std::array<int, 3> far_corners(std::span<const int> points) const;
  [[nodiscard]] std::size_t constants() const { return single_.size() + double_.size(); }
  void push_constant(double k);
  template <class Scalar>
  const Scalar* constants_from(std::size_t first) const;
  template <class Real, class Quad>
  void add_tetrahedra(const Block& block, const Quad* u, Quad* force, Real& stretch) const;
  template <class Real, int pattern, class Quad>
  void add_cubes(const Block& block, const Quad* u, Quad* force, Real& stretch) const;
  template <class Real, class Quad>
  double sum_block(const Block& block, std::span<const Vec3> position, Quad* force) const;

  bool exact_;
  int lattices_ = 0, stray_ = -1;
  std::vector<Vec3> rest_;
  std::vector<Block> blocks_;
  std::vector<int> members_;            // points of all blocks
  std::vector<std::uint16_t> corners_;  // of all groups, a member number for each corner and slot
  std::vector<float> single_;           // constants of all groups, one for each element and slot
  std::vector<double> double_;          // the same where forces are exact; one of both is empty
  std::vector<int> offsets_, entries_;  // the members that each point is
};

}  // namespace turgor
