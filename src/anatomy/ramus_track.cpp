#include "anatomy/ramus_track.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/imaging/segmentation.hpp"

namespace turgor {
namespace {

constexpr double kBelowMm = 22;    ///< following starts this far below the plane, in the body
constexpr double kAboveMm = 75;    ///< and ends here: above every condyle
constexpr double kBehindMm = 110;  ///< behind the front of the body
constexpr double kAsideMm = 80;
/// A section belongs to the mandible whole where this part of it lies on the section below.
constexpr double kContinues = 0.7;
/// A condyle's dome rises no higher than this above its last free section.
constexpr double kDomeMm = 13;

enum : std::uint8_t { kFound = 1, kOpen = 2 };

/// The region of the mandible in sections parallel to the occlusal plane, as a volume whose k axis is the
/// plane's normal.
struct Sections {
  CtVolume hu;
  LabelVolume bone, body, rows;
  LabelVolume mandible;  ///< what is found: kFound, kOpen where the flood shall decide, else 0
  int first = 0;         ///< section where following starts

  [[nodiscard]] double height(int k) const { return (k - zero) * hu.grid.spacing.z; }
  int zero = 0;  ///< section in the occlusal plane
  [[nodiscard]] std::size_t section_size() const {
    return static_cast<std::size_t>(hu.grid.size[0]) * static_cast<std::size_t>(hu.grid.size[1]);
  }
};

Sections cut_sections(const CtVolume& hu, const LabelVolume& bone, const LabelVolume& body,
                      const LabelVolume& rows, const Plane& occlusal) {
  const Grid& from = hu.grid;
  const Vec3 s = from.spacing;
  const double step = std::max(0.7, std::min({s.x, s.y, s.z}));
  // The body's box gives the middle and the front.
  Box3 box;
  const VoxelBox voxels = bounding_box(body);
  for (int corner = 0; corner < 8; ++corner) {
    const auto pick = [&](int axis) {
      const auto a = static_cast<std::size_t>(axis);
      return double(corner >> axis & 1 ? voxels.upper[a] : voxels.lower[a]);
    };
    box.extend(from.to_patient({pick(0), pick(1), pick(2)}));
  }
  const Vec3 up = occlusal.normal, left = normalized(cross(Vec3{0, 1, 0}, up)), back = cross(up, left);
  const Vec3 front{box.centre().x, box.lower.y - 5, box.centre().z};
  const Vec3 middle = front - up * occlusal.signed_distance(front);

  Sections sections;
  Grid g;
  g.size = {static_cast<int>(2 * kAsideMm / step), static_cast<int>(kBehindMm / step),
            static_cast<int>((kBelowMm + kAboveMm) / step)};
  g.spacing = {step, step, step};
  g.direction = Mat3{{left, back, up}};
  sections.zero = static_cast<int>(kBelowMm / step);
  g.origin = middle - left * (0.5 * (g.size[0] - 1) * step) - up * (sections.zero * step);
  sections.hu = CtVolume(g, -1000);
  sections.bone = LabelVolume(g);
  sections.body = LabelVolume(g);
  sections.rows = LabelVolume(g);
  sections.mandible = LabelVolume(g);
  parallel_for(static_cast<std::size_t>(g.size[2]), 2, [&](std::size_t begin, std::size_t end) {
    for (int k = static_cast<int>(begin); k < static_cast<int>(end); ++k) {
      for (int j = 0; j < g.size[1]; ++j) {
        const Vec3 row = from.to_index(g.to_patient({0, double(j), double(k)}));
        const Vec3 along = from.to_index(g.to_patient({1, double(j), double(k)})) - row;
        for (int i = 0; i < g.size[0]; ++i) {
          const Vec3 at = row + along * double(i);
          const int x = static_cast<int>(std::lround(at.x)), y = static_cast<int>(std::lround(at.y)),
                    z = static_cast<int>(std::lround(at.z));
          if (!from.contains(x, y, z)) continue;
          const std::size_t v = from.offset(x, y, z), w = g.offset(i, j, k);
          sections.hu.voxels[w] = hu.voxels[v];
          sections.bone.voxels[w] = bone.voxels[v];
          sections.body.voxels[w] = body.voxels[v];
          sections.rows.voxels[w] = rows.voxels[v];
        }
      }
    }
  });
  return sections;
}

LabelVolume one_section(const LabelVolume& volume, int k) {
  const Index3 n = volume.grid.size;
  return crop(volume, {{0, 0, k}, {n[0] - 1, n[1] - 1, k}});
}
LabelVolume found_in_section(const Sections& s, int k) {
  LabelVolume section = one_section(s.mandible, k);
  for (std::uint8_t& cell : section.voxels) cell = cell == kFound ? 1 : 0;
  return section;
}

/// The cells of a column from section k0 up, as Hounsfield numbers; ends where bone ends.
std::vector<double> column(const Sections& s, std::size_t cell, int k0) {
  std::vector<double> values;
  const int most = static_cast<int>(kDomeMm / s.hu.grid.spacing.z);
  for (int k = k0; k < s.hu.grid.size[2] && k <= k0 + most; ++k) {
    const std::size_t v = static_cast<std::size_t>(k) * s.section_size() + cell;
    if (s.bone.voxels[v] == 0) break;
    values.push_back(s.hu.voxels[v]);
  }
  return values;
}

/// How many cells of a column of merged bone belong to the condyle: up to the seam.
int cells_below_seam(const std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto top = std::max_element(values.begin(), values.end());
  const double peak = *top;
  const double below = *std::min_element(values.begin(), top + 1),
               above = *std::min_element(top, values.end());
  // The bright layer around the peak, up to halfway to the marrow on either side.
  auto first = top, last = top;
  while (first != values.begin() && *(first - 1) > 0.5 * (peak + below)) --first;
  while (last + 1 != values.end() && *(last + 1) > 0.5 * (peak + above)) ++last;
  // A second bright layer close by: the joint space is the dark seam between the two.
  constexpr double kSeam = 0.8;
  for (auto other = values.begin(); other != values.end(); ++other) {
    const auto [lower, upper] = std::minmax(other, top);
    if (upper - lower < 2 || *other < 0.75 * peak) continue;
    const auto seam = std::min_element(lower, upper);
    if (*seam < kSeam * *other) return static_cast<int>(seam - values.begin());
  }
  return static_cast<int>((first - values.begin() + last - values.begin() + 1) / 2);
}

/// Cells where the mandible has run into the skull: on the last free section, from section `first` on.
struct Contact {
  int first = 0;
  std::vector<std::size_t> cells;
};

/// The block of cells around a contact: a condyle and its fossa.
VoxelBox block_around(const Sections& s, const Contact& contact) {
  const auto nx = static_cast<std::size_t>(s.hu.grid.size[0]);
  const double step = s.hu.grid.spacing.x;
  constexpr double kAroundMm = 12, kOverMm = 20;
  VoxelBox box{{s.hu.grid.size[0], s.hu.grid.size[1], contact.first - 1}, {-1, -1, 0}};
  for (const std::size_t cell : contact.cells) {
    const int i = static_cast<int>(cell % nx), j = static_cast<int>(cell / nx),
              around = static_cast<int>(kAroundMm / step);
    box.lower = {std::min(box.lower[0], i - around), std::min(box.lower[1], j - around), box.lower[2]};
    box.upper = {std::max(box.upper[0], i + around), std::max(box.upper[1], j + around), 0};
  }
  box.upper[2] = contact.first + static_cast<int>(kOverMm / step);
  return clipped(box, s.hu.grid);
}

/// The condyle where some threshold parts it from its fossa: what hangs together with the last free section
/// and does not reach the block's sides or top. Its bone and the skull's are marked, the seam between is left
/// to the flood.
bool part_at_dark_seam(Sections& s, const Contact& contact, double lowest, double highest) {
  const VoxelBox box = block_around(s, contact);
  const CtVolume hu = crop(s.hu, box);
  const LabelVolume bone = crop(s.bone, box), found = crop(s.mandible, box);
  const Grid& g = bone.grid;
  LabelVolume dense(g);
  for (double part = 0; part < 1.01; part += 0.125) {
    const double level = lowest + part * (highest - lowest);
    for (std::size_t v = 0; v < dense.voxels.size(); ++v)
      dense.voxels[v] = bone.voxels[v] != 0 && hu.voxels[v] >= level;
    const Components pieces = connected_components(dense);
    std::vector<bool> seed(pieces.sizes.size() + 1, false), leaks(pieces.sizes.size() + 1, false);
    for (int k = 0; k < g.size[2]; ++k) {
      for (int j = 0; j < g.size[1]; ++j) {
        for (int i = 0; i < g.size[0]; ++i) {
          const auto piece = static_cast<std::size_t>(pieces.labels.at(i, j, k));
          if (k == 0 && found.at(i, j, k) == kFound) seed[piece] = true;
          const bool side = i == 0 || j == 0 || i == g.size[0] - 1 || j == g.size[1] - 1;
          if (k == g.size[2] - 1 || (k > 0 && side)) leaks[piece] = true;
        }
      }
    }
    std::size_t held = 0;
    bool whole = true;
    for (std::size_t piece = 1; piece < seed.size(); ++piece) {
      if (seed[piece]) held += pieces.sizes[piece - 1], whole = whole && !leaks[piece];
    }
    if (!whole || held < contact.cells.size()) continue;
    LabelVolume part_found(g, 0);
    for (std::size_t v = 0; v < part_found.voxels.size(); ++v) {
      const auto piece = static_cast<std::size_t>(pieces.labels.voxels[v]);
      part_found.voxels[v] = piece == 0 ? kOpen : seed[piece] ? kFound : 0;
    }
    for (int i = 0; i < g.size[0]; ++i) {  // sections below the contact keep what was found
      for (int j = 0; j < g.size[1]; ++j) part_found.at(i, j, 0) = found.at(i, j, 0);
    }
    paste(s.mandible, part_found, box.lower);
    return true;
  }
  return false;
}

/// Cuts the columns over a contact, at heights smoothed by the median of the neighbours' so that no column
/// stands out.
void cut_contact(Sections& s, const Contact& contact) {
  const int nx = s.hu.grid.size[0];
  std::vector<int> heights(s.section_size(), -1);
  for (const std::size_t cell : contact.cells)
    heights[cell] = cells_below_seam(column(s, cell, contact.first));
  for (const std::size_t cell : contact.cells) {
    std::vector<int> around;
    for (int dj = -2; dj <= 2; ++dj) {
      for (int di = -2; di <= 2; ++di) {
        const auto other = static_cast<std::ptrdiff_t>(cell) + dj * nx + di;
        if (other < 0 || other >= static_cast<std::ptrdiff_t>(heights.size())) continue;
        if (heights[static_cast<std::size_t>(other)] >= 0)
          around.push_back(heights[static_cast<std::size_t>(other)]);
      }
    }
    const auto middle = around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2);
    std::nth_element(around.begin(), middle, around.end());
    for (int k = contact.first; k < contact.first + *middle && k < s.hu.grid.size[2]; ++k) {
      s.mandible.voxels[static_cast<std::size_t>(k) * s.section_size() + cell] = kFound;
    }
  }
}

/// The bone of section k that may be mandible: teeth left out between the rows.
LabelVolume candidates(const Sections& s, int k, double band_mm) {
  LabelVolume section = one_section(s.bone, k);
  if (std::abs(s.height(k)) > band_mm) return section;
  const std::size_t base = static_cast<std::size_t>(k) * s.section_size();
  for (std::size_t c = 0; c < section.voxels.size(); ++c) {
    if (s.rows.voxels[base + c] != 0) section.voxels[c] = 0;
  }
  return section;
}

/// The body in the first section: components that hold marked bone.
void start(Sections& s) {
  const Components parts = connected_components(one_section(s.bone, s.first));
  const std::size_t base = static_cast<std::size_t>(s.first) * s.section_size();
  std::vector<bool> marked(parts.sizes.size() + 1, false);
  for (std::size_t c = 0; c < s.section_size(); ++c) {
    if (s.body.voxels[base + c] != 0) marked[static_cast<std::size_t>(parts.labels.voxels[c])] = true;
  }
  for (std::size_t c = 0; c < s.section_size(); ++c) {
    const auto part = static_cast<std::size_t>(parts.labels.voxels[c]);
    s.mandible.voxels[base + c] = part != 0 && marked[part];
  }
}

/// Takes the components of section k that continue the section below; returns where one has run into other
/// bone. `closed` are cells whose column has been cut already.
std::vector<std::size_t> follow(Sections& s, int k, double band_mm, const std::vector<bool>& closed) {
  const double step = s.hu.grid.spacing.x;
  const LabelVolume before = found_in_section(s, k - 1), near = dilate(before, 1.5 * step);
  const Components parts = connected_components(candidates(s, k, band_mm));
  std::vector<std::size_t> shared(parts.sizes.size() + 1, 0);
  for (std::size_t c = 0; c < s.section_size(); ++c) {
    if (near.voxels[c] != 0 && !closed[c]) ++shared[static_cast<std::size_t>(parts.labels.voxels[c])];
  }
  std::vector<std::size_t> merged;
  const std::size_t base = static_cast<std::size_t>(k) * s.section_size();
  for (std::size_t c = 0; c < s.section_size(); ++c) {
    const auto part = static_cast<std::size_t>(parts.labels.voxels[c]);
    if (part == 0 || shared[part] == 0) continue;
    if (static_cast<double>(shared[part]) >= kContinues * static_cast<double>(parts.sizes[part - 1])) {
      if (!closed[c]) s.mandible.voxels[base + c] = kFound;
    } else if (before.voxels[c] != 0 && !closed[c]) {
      merged.push_back(c);
    }
  }
  return merged;
}

void close(const Sections& s, const VoxelBox& box, std::vector<bool>& closed) {
  const int nx = s.hu.grid.size[0];
  for (int j = box.lower[1]; j <= box.upper[1]; ++j) {
    for (int i = box.lower[0]; i <= box.upper[0]; ++i) closed[static_cast<std::size_t>(j * nx + i)] = true;
  }
}

/// One contact for each side of the mandible.
std::vector<Contact> contacts_by_side(const Sections& s, int k, const std::vector<std::size_t>& cells) {
  std::vector<Contact> sides(2);
  for (const std::size_t cell : cells) {
    const bool left =
        cell % static_cast<std::size_t>(s.hu.grid.size[0]) > static_cast<std::size_t>(s.hu.grid.size[0]) / 2;
    sides[left ? 1 : 0].cells.push_back(cell);
  }
  for (Contact& side : sides) side.first = k;
  std::erase_if(sides, [](const Contact& side) { return side.cells.empty(); });
  return sides;
}

/// Levels between which a seam is looked for: the bone level and four fifths of the cortical bone's density.
std::pair<double, double> seam_levels(const Sections& s) {
  std::vector<std::int16_t> values;
  std::int16_t least = 32767;
  for (std::size_t v = 0; v < s.bone.voxels.size(); ++v) {
    if (s.bone.voxels[v] == 0) continue;
    least = std::min(least, s.hu.voxels[v]);
    if (s.rows.voxels[v] == 0) values.push_back(s.hu.voxels[v]);
  }
  if (values.empty()) return {least, least};
  const auto dense =
      values.begin() + static_cast<std::ptrdiff_t>(0.9 * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), dense, values.end());
  return {least, std::max<double>(least, 0.8 * *dense)};
}

void follow_upwards(Sections& s, double band_mm) {
  std::vector<bool> closed(s.section_size(), false);
  const auto [lowest, highest] = seam_levels(s);
  for (int k = s.first + 1; k < s.hu.grid.size[2]; ++k) {
    const std::vector<std::size_t> merged = follow(s, k, band_mm, closed);
    if (s.height(k) <= band_mm) {
      for (const std::size_t c : merged)
        s.mandible.voxels[static_cast<std::size_t>(k) * s.section_size() + c] = kFound;
      continue;
    }
    for (const Contact& contact : contacts_by_side(s, k, merged)) {
      if (part_at_dark_seam(s, contact, lowest, highest)) {
        close(s, block_around(s, contact), closed);
      } else {
        cut_contact(s, contact);
        for (const std::size_t c : contact.cells) closed[c] = true;
      }
    }
  }
}

}  // namespace

void mark_rami(const CtVolume& hu, const LabelVolume& bone, const LabelVolume& body, const LabelVolume& rows,
               const Plane& occlusal, double band_mm, LabelVolume& markers) {
  Sections s = cut_sections(hu, bone, body, rows, occlusal);
  start(s);
  follow_upwards(s, band_mm);
  const Grid& g = hu.grid;
  parallel_for(static_cast<std::size_t>(g.size[2]), 2, [&](std::size_t begin, std::size_t end) {
    for (int k = static_cast<int>(begin); k < static_cast<int>(end); ++k) {
      for (int j = 0; j < g.size[1]; ++j) {
        for (int i = 0; i < g.size[0]; ++i) {
          const std::size_t v = g.offset(i, j, k);
          if (bone.voxels[v] == 0) continue;
          const Vec3 p = g.to_patient({double(i), double(j), double(k)});
          if (occlusal.signed_distance(p) < band_mm) continue;
          const Vec3 at = s.hu.grid.to_index(p);
          const int x = static_cast<int>(std::lround(at.x)), y = static_cast<int>(std::lround(at.y)),
                    z = static_cast<int>(std::lround(at.z));
          if (!s.hu.grid.contains(x, y, z)) {
            markers.voxels[v] = kSkull;
          } else if (s.bone.at(x, y, z) != 0 && s.mandible.at(x, y, z) != kOpen) {
            // Cells and voxels do not match to the last one; what a cell leaves open the flood fills.
            markers.voxels[v] = s.mandible.at(x, y, z) == kFound ? kMandible : kSkull;
          }
        }
      }
    }
  });
}

}  // namespace turgor
