// Springs, areas and volumes cut into blocks of near points, so that a block's points and forces stay in the
// cache and no force of a single element goes to memory.
//
//     block:  own points | halo            elements:  [ linear | relaxing linear | … | triangles | tetrahedra
//     ]
//             forces wanted | other corners of elements that lead out
//
// An element between two blocks is computed by both, each for its own points; the same bits in either. Blocks
// depend on the network alone, so sums have the same bits on any number of threads.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "turgor/dynamics/time_stepper.hpp"

namespace turgor {

class NetworkBlocks {
 public:
  using Quad = TimeStepper::Workspace::Quad;

  /// `share` for each spring: the part of its force that acts on an end; springs with 0 are left out.
  NetworkBlocks(const MotionModel& model, std::span<const double> share);

  [[nodiscard]] std::size_t count() const { return blocks_.size(); }
  void set_rest_length(int spring, double rest_length_mm);

  /// Whether a sum tells the stiffness too, which only the choice of a step needs.
  enum class Wants : std::uint8_t { forces, stiffness };

  /// What springs, areas and volumes do to the own points of a block.
  struct Sums {
    std::span<const int> points;     ///< own points, all mobile
    const Quad* position = nullptr;  ///< x y z 0 of each
    const Quad* velocity = nullptr;
    const Quad* force =
        nullptr;         ///< x y z of the force, then the row of Gershgorin's theorem, N/mm, where wanted
    int coincident = 0;  ///< springs without direction, each counted in one block alone
    bool bare = true;    ///< no element at any of the points: none of the pointers is set
  };
  /// `offset` is what each relaxing spring has lost of its tension. Real is Lanes, or double for the scalar
  /// twin, which does the same operations in the same order. Spans in the result lie in `scratch`.
  template <class Real, Wants wants>
  Sums sum(std::size_t block, const MotionState& state, std::span<const double> offset,
           std::vector<Quad>& scratch) const;

 private:
  static constexpr std::size_t kGroups = 2 * kSpringLaws.size();  // of each law: plain, relaxing
  struct Block {
    std::size_t first_member, own, members;
    std::array<std::size_t, kGroups + 1> group;  // slots of springs, whole lanes
    std::size_t first_area, areas_end;           // slots of triangles, whole lanes
    std::size_t first_volume, volumes_end;       // of tetrahedra
  };
  struct Buffers {
    Quad *position, *velocity, *force;
  };
  struct Draft {
    int spring, a, b;  // ends as numbers within the block
  };
  struct Layout {
    const MotionModel& model;
    std::span<const double> share;
    const NetworkEnergy::Incidence &springs_at, &areas_at, &volumes_at;
    std::span<const int> relaxing_number;  // of each spring; −1: it does not relax
  };

  void lay_out_block(const Layout& layout, std::span<const int> own, std::vector<int>& local);
  template <class Enter>
  void lay_out_springs(const Layout& layout, Block& block, std::span<const int> own,
                       std::span<const int> local, const Enter& enter);
  void lay_out_group(const Layout& layout, std::span<const Draft> drafts);
  template <class Element, class Enter>
  static std::vector<int> elements_at(const std::vector<Element>& elements,
                                      const NetworkEnergy::Incidence& at_point, std::span<const int> own,
                                      std::span<const int> local, const Enter& enter);
  template <class Visit>
  static void visit_slots(std::span<const int> elements, const Visit& visit);
  template <class Enter>
  void lay_out_areas(const Layout& layout, Block& block, std::span<const int> own, std::span<const int> local,
                     const Enter& enter);
  template <class Enter>
  void lay_out_volumes(const Layout& layout, Block& block, std::span<const int> own,
                       std::span<const int> local, const Enter& enter);
  template <class Real, Wants wants, SpringLaw law>
  int add_group(const Block& block, std::size_t group, std::span<const double> offset,
                const Buffers& buffers) const;
  template <class Real, Wants wants>
  void add_areas(const Block& block, const Buffers& buffers) const;
  template <class Real, Wants wants>
  void add_volumes(const Block& block, const Buffers& buffers) const;
  [[nodiscard]] int count_coincident(const Block& block, std::size_t slot, std::size_t slots,
                                     const Quad* position) const;

  std::vector<Block> blocks_;
  std::vector<int> members_;  // points of all blocks, own before halo
  // Slots of all blocks; those that fill up lanes have stiffness 0 and spring −1.
  std::vector<int> a_, b_, spring_, relaxing_;
  std::vector<double> rest_length_, stiffness_;
  std::vector<double> viscosity_, cutoff_;           // empty where no spring has one
  std::vector<std::array<int, 2>> slots_of_spring_;  // −1: not there
  // Slots of triangles; those that fill up lanes have stiffness 0.
  std::array<std::vector<int>, 3> area_corner_;
  std::vector<double> doubled_area_, area_stiffness_;  // n₀ = 2 A₀, k/n₀²
  // Slots of tetrahedra V₀, k and guard g; those that fill up lanes are all zero.
  std::array<std::vector<int>, 4> corner_;
  std::vector<double> sixth_inverse_, sixth_modulus_, sixth_guard_;  // 1/(6 V₀), k/6, g/6
  std::vector<char> mobile_;
  bool viscous_ = false, cut_ = false;
};

}  // namespace turgor
