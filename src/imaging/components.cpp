#include "imaging/runs.hpp"
#include "turgor/imaging/segmentation.hpp"

namespace turgor {
namespace {

/// Runs of the components that keep(label) accepts, as a mask.
template <class Keep>
LabelVolume painted(const detail::ConnectedRuns& connected, const Grid& grid, Keep&& keep) {
  LabelVolume mask(grid);
  detail::paint_runs(connected, mask, [&](std::size_t run) {
    return static_cast<std::uint8_t>(keep(static_cast<std::size_t>(connected.component[run])) ? 1 : 0);
  });
  return mask;
}

}  // namespace

Components connected_components(const LabelVolume& mask) {
  if (!detail::is_whole(mask)) return {};
  detail::ConnectedRuns connected = detail::connect_runs(detail::pack_nonzero(mask));
  Components result{Volume<std::int32_t>(mask.grid), {}};
  detail::paint_runs(connected, result.labels, [&](std::size_t run) { return connected.component[run]; });
  result.sizes = std::move(connected.sizes);
  return result;
}

LabelVolume component_mask(const Components& components, int label) {
  if (!detail::is_whole(components.labels)) return {};
  LabelVolume mask(components.labels.grid);
  parallel_for(mask.voxels.size(), 1 << 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) mask.voxels[v] = components.labels.voxels[v] == label ? 1 : 0;
  });
  return mask;
}

LabelVolume largest_component(const LabelVolume& mask) {
  if (!detail::is_whole(mask)) return mask;
  return painted(detail::connect_runs(detail::pack_nonzero(mask)), mask.grid,
                 [](std::size_t component) { return component == 1; });
}

LabelVolume remove_small_components(const LabelVolume& mask, std::size_t least_voxels) {
  if (!detail::is_whole(mask)) return mask;
  const detail::ConnectedRuns connected = detail::connect_runs(detail::pack_nonzero(mask));
  return painted(connected, mask.grid,
                 [&](std::size_t component) { return connected.sizes[component - 1] >= least_voxels; });
}

LabelVolume reachable_from(const LabelVolume& mask, const std::vector<Index3>& seeds) {
  if (!detail::is_whole(mask)) return mask;
  const detail::ConnectedRuns connected = detail::connect_runs(detail::pack_nonzero(mask));
  std::vector<bool> reached(connected.sizes.size() + 1, false);
  for (const Index3& s : seeds) {
    if (mask.grid.contains(s[0], s[1], s[2])) {
      reached[static_cast<std::size_t>(connected.component_at(s[0], s[1], s[2]))] = true;
    }
  }
  return painted(connected, mask.grid, [&](std::size_t component) { return reached[component]; });
}

LabelVolume fill_holes(const LabelVolume& mask) {
  if (!detail::is_whole(mask)) return mask;
  const detail::ConnectedRuns outside = detail::connect_runs(detail::complement(detail::pack_nonzero(mask)));
  const Index3 n = mask.grid.size;
  std::vector<bool> open(outside.sizes.size() + 1, false);
  for (std::size_t r = 0; r < outside.rows(); ++r) {
    const int j = static_cast<int>(r % static_cast<std::size_t>(n[1]));
    const int k = static_cast<int>(r / static_cast<std::size_t>(n[1]));
    const bool border_row = j == 0 || k == 0 || j == n[1] - 1 || k == n[2] - 1;
    for (std::size_t run = outside.row_begin[r]; run < outside.row_begin[r + 1]; ++run) {
      if (border_row || outside.runs[run].begin == 0 || outside.runs[run].end == n[0]) {
        open[static_cast<std::size_t>(outside.component[run])] = true;
      }
    }
  }
  LabelVolume filled(mask.grid, 1);
  detail::paint_runs(outside, filled, [&](std::size_t run) {
    return static_cast<std::uint8_t>(open[static_cast<std::size_t>(outside.component[run])] ? 0 : 1);
  });
  return filled;
}

}  // namespace turgor
