#include "turgor/tissue/stiffness_matrix.hpp"

#include <algorithm>
#include <cmath>

#include "tissue/area_element.hpp"
#include "tissue/incidence.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

constexpr std::size_t kRowGrain = 256;

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

Mat3 negative(const Mat3& m) {
  return Mat3{{-m.c[0], -m.c[1], -m.c[2]}};
}

// m += a bᵀ.
void add_outer(Mat3& m, const Vec3& a, const Vec3& b) {
  m.c[0] += a * b.x;
  m.c[1] += a * b.y;
  m.c[2] += a * b.z;
}

// The edges opposite to corner `a` and each other corner, as volume_block() has them.
struct OppositeEdges {
  Vec3 w[4];
};
OppositeEdges opposite_edges(const Vec3 e[3], int a) {
  switch (a) {
    case 0:
      return {{{}, e[1] - e[2], e[2] - e[0], e[0] - e[1]}};
    case 1:
      return {{e[2] - e[1], {}, -e[2], e[1]}};
    case 2:
      return {{e[0] - e[2], e[2], {}, -e[0]}};
    default:
      return {{e[1] - e[0], -e[1], e[0], {}}};
  }
}

// The four blocks of one corner's row of a volume; the same as volume_block(), which is the reference, in one
// go. targets[b] is null where corner b is held.
void add_volume_row(const VolumeStiffness& v, int a, double projection, Mat3* const targets[4]) {
  const Vec3 scaled = v.gradient[a] * v.bulk;
  const double twist = (1 - 0.5 * projection) * v.stress / 6.0,
               half = 0.5 * projection * std::abs(v.stress) / 6.0;
  const OppositeEdges edges = opposite_edges(v.edge, a);
  add_outer(*targets[a], scaled, v.gradient[a]);
  for (int b = 0; b < 4; ++b) {
    if (b == a) continue;
    const Vec3& w = edges.w[b];
    if (half > 0) {
      const double l = length(w);
      add_outer(*targets[a], w * (l > 0 ? -half / l : 0.0), w);
      targets[a]->c[0].x += half * l, targets[a]->c[1].y += half * l, targets[a]->c[2].z += half * l;
    }
    if (targets[b] == nullptr) continue;
    Mat3& m = *targets[b];
    add_outer(m, scaled, v.gradient[b]);
    const Vec3 t = w * twist;
    m.c[0].y += t.z, m.c[0].z -= t.y;
    m.c[1].x -= t.z, m.c[1].z += t.x;
    m.c[2].x += t.y, m.c[2].y -= t.x;
  }
}

void add_area_row(const AreaStiffness& area, int a, double projection, Mat3* const targets[3]) {
  const AreaParts parts = parts_of(area, projection);
  const Vec3 own = area_gradient(area.normal, area.edge[a]);
  for (int b = 0; b < 3; ++b) {
    if (targets[b] != nullptr)
      add_area_block(area, parts, a, b, own, area_gradient(area.normal, area.edge[b]), *targets[b]);
  }
}

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

void StiffnessMatrix::add_to_diagonal(int row, const Mat3& block) {
  add(blocks_[diagonal_[row]], block);
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
  const auto& areas = energy.area_incidence();
  for (int k = areas.offsets[point]; k < areas.offsets[point + 1]; ++k) {
    const int corner = areas.entries[k] % 3;
    Mat3* targets[3];
    for (int c = 0; c < 3; ++c) {
      const int s = c == corner ? diagonal_[row] : *next++;
      targets[c] = s < 0 ? nullptr : &blocks_[s];
    }
    add_area_row(stiffness.areas[areas.entries[k] / 3], corner, stiffness.projection, targets);
  }
  const auto& volumes = energy.volume_incidence();
  for (int k = volumes.offsets[point]; k < volumes.offsets[point + 1]; ++k) {
    const int corner = volumes.entries[k] % 4;
    Mat3* targets[4];
    for (int c = 0; c < 4; ++c) {
      const int s = c == corner ? diagonal_[row] : *next++;
      targets[c] = s < 0 ? nullptr : &blocks_[s];
    }
    add_volume_row(stiffness.volumes[volumes.entries[k] / 4], corner, stiffness.projection, targets);
  }
  if (const int c = energy.contact_at(point); c >= 0) {
    const Vec3& normal = energy.contacts()[c].normal;
    add_outer(diagonal, normal * stiffness.contacts[c], normal);
  }
}

}  // namespace turgor
