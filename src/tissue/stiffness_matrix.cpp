#include "turgor/tissue/stiffness_matrix.hpp"

#include <algorithm>

#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

constexpr std::size_t kRowGrain = 256;

// Every other corner of the elements at a point, in the order in which rows are assembled.
template <class Visit>
void visit_neighbours(const NetworkEnergy& energy, int point, Visit&& visit) {
  const auto& springs = energy.spring_incidence();
  for (int k = springs.offsets[point]; k < springs.offsets[point + 1]; ++k) {
    const auto& ends = energy.spring_ends()[springs.entries[k] / 2];
    visit(springs.entries[k] % 2 == 0 ? ends.b : ends.a);
  }
  const auto& volumes = energy.volume_incidence();
  for (int k = volumes.offsets[point]; k < volumes.offsets[point + 1]; ++k) {
    const auto& corners = energy.volume_corners()[volumes.entries[k] / 4];
    for (int c = 0; c < 4; ++c) {
      if (c != volumes.entries[k] % 4) visit(corners.p[c]);
    }
  }
}

void add(Mat3& m, const Mat3& n) {
  for (std::size_t j = 0; j < 3; ++j) m.c[j] += n.c[j];
}

Mat3 spring_block(const SpringStiffness& s) {
  const Vec3 scaled = s.direction * (s.axial - s.transverse);
  Mat3 block{{scaled * s.direction.x, scaled * s.direction.y, scaled * s.direction.z}};
  block.c[0].x += s.transverse;
  block.c[1].y += s.transverse;
  block.c[2].z += s.transverse;
  return block;
}

Mat3 negative(const Mat3& m) { return Mat3{{-m.c[0], -m.c[1], -m.c[2]}}; }

}  // namespace

StiffnessMatrix::StiffnessMatrix(const NetworkEnergy& energy, std::vector<int> unknowns)
    : unknowns_(std::move(unknowns)), row_of_point_(static_cast<std::size_t>(energy.point_count()), -1) {
  for (int row = 0; row < rows(); ++row) row_of_point_[unknowns_[row]] = row;
  make_pattern(energy);
  make_slots(energy);
  blocks_.resize(columns_.size());
}

void StiffnessMatrix::make_pattern(const NetworkEnergy& energy) {
  offsets_.assign(1, 0);
  std::vector<int> seen(unknowns_.size(), -1);
  for (int row = 0; row < rows(); ++row) {
    const auto first = static_cast<std::ptrdiff_t>(columns_.size());
    columns_.push_back(row);
    seen[row] = row;
    visit_neighbours(energy, unknowns_[row], [&](int point) {
      const int column = row_of_point_[point];
      if (column < 0 || seen[column] == row) return;
      seen[column] = row;
      columns_.push_back(column);
    });
    std::sort(columns_.begin() + first, columns_.end());
    offsets_.push_back(static_cast<int>(columns_.size()));
    diagonal_.push_back(slot(row, unknowns_[row]));
  }
}

int StiffnessMatrix::slot(int row, int point) const {
  const int column = row_of_point_[point];
  if (column < 0) return -1;
  const auto begin = columns_.begin() + offsets_[row], end = columns_.begin() + offsets_[row + 1];
  return static_cast<int>(std::lower_bound(begin, end, column) - columns_.begin());
}

void StiffnessMatrix::make_slots(const NetworkEnergy& energy) {
  slot_offsets_.assign(1, 0);
  for (int row = 0; row < rows(); ++row) {
    visit_neighbours(energy, unknowns_[row], [&](int point) { slots_.push_back(slot(row, point)); });
    slot_offsets_.push_back(static_cast<int>(slots_.size()));
  }
}

void StiffnessMatrix::assemble(const NetworkEnergy& energy, const ElementStiffness& stiffness) {
  parallel_for(unknowns_.size(), kRowGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) assemble_row(energy, stiffness, static_cast<int>(row));
  });
}

void StiffnessMatrix::assemble_row(const NetworkEnergy& energy, const ElementStiffness& stiffness, int row) {
  for (int k = offsets_[row]; k < offsets_[row + 1]; ++k) blocks_[k] = Mat3{{Vec3{}, Vec3{}, Vec3{}}};
  Mat3& diagonal = blocks_[diagonal_[row]];
  const int* next = slots_.data() + slot_offsets_[row];
  const int point = unknowns_[row];
  const auto& springs = energy.spring_incidence();
  for (int k = springs.offsets[point]; k < springs.offsets[point + 1]; ++k) {
    const Mat3 block = spring_block(stiffness.springs[springs.entries[k] / 2]);
    add(diagonal, block);
    if (const int s = *next++; s >= 0) add(blocks_[s], negative(block));
  }
  const auto& volumes = energy.volume_incidence();
  for (int k = volumes.offsets[point]; k < volumes.offsets[point + 1]; ++k) {
    const int corner = volumes.entries[k] % 4;
    const VolumeStiffness& volume = stiffness.volumes[volumes.entries[k] / 4];
    add(diagonal, volume_block(volume, corner, corner, stiffness.convexity));
    for (int c = 0; c < 4; ++c) {
      if (c == corner) continue;
      if (const int s = *next++; s >= 0) add(blocks_[s], volume_block(volume, corner, c, stiffness.convexity));
    }
  }
}

}  // namespace turgor
