// Which elements meet at each point.
#pragma once

#include "turgor/tissue/network_energy.hpp"

namespace turgor {

/// Counting sort of (point, element corner) pairs, `point_of` telling the point of each of `entries`; entries
/// at a point ascend.
template <class PointOf>
NetworkEnergy::Incidence make_incidence(int points, int entries, PointOf&& point_of) {
  NetworkEnergy::Incidence list;
  list.offsets.assign(static_cast<std::size_t>(points) + 1, 0);
  list.entries.resize(static_cast<std::size_t>(entries));
  for (int e = 0; e < entries; ++e) ++list.offsets[point_of(e) + 1];
  for (int p = 0; p < points; ++p) list.offsets[p + 1] += list.offsets[p];
  std::vector<int> next(list.offsets.begin(), list.offsets.end() - 1);
  for (int e = 0; e < entries; ++e) list.entries[next[point_of(e)]++] = e;
  return list;
}

/// Every other corner of the elements at a point, as often as they share one: springs, areas, volumes.
template <class Visit>
void visit_neighbours(const NetworkEnergy& energy, int point, Visit&& visit) {
  const auto& springs = energy.spring_incidence();
  for (int k = springs.offsets[point]; k < springs.offsets[point + 1]; ++k) {
    const auto& ends = energy.spring_ends()[springs.entries[k] / 2];
    visit(springs.entries[k] % 2 == 0 ? ends.b : ends.a);
  }
  const auto& areas = energy.area_incidence();
  for (int k = areas.offsets[point]; k < areas.offsets[point + 1]; ++k) {
    const auto& corners = energy.area_corners()[areas.entries[k] / 3];
    for (int c = 0; c < 3; ++c) {
      if (c != areas.entries[k] % 3) visit(corners.p[c]);
    }
  }
  const auto& volumes = energy.volume_incidence();
  for (int k = volumes.offsets[point]; k < volumes.offsets[point + 1]; ++k) {
    const auto& corners = energy.volume_corners()[volumes.entries[k] / 4];
    for (int c = 0; c < 4; ++c) {
      if (c != volumes.entries[k] % 4) visit(corners.p[c]);
    }
  }
}

}  // namespace turgor
