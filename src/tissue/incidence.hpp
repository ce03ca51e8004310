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

}  // namespace turgor
