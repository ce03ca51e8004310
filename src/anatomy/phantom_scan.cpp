#include <atomic>
#include <numbers>
#include <numeric>

#include "anatomy/phantom_pose.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"

namespace turgor::phantom {
namespace {

constexpr int layer_count = TissueProbe::layer_count;
constexpr int block = 16;            // voxels along the edge of the first cells
constexpr double largest_local = 8;  // mm: smaller cells get fields of their own

/// A range of voxels, all layers but `active` known to be absent in it.
struct Cell {
  Index3 from, to;
  std::uint32_t active;
};

// What one pass over the voxels needs: the cells are split until one layer covers them, the rest goes voxel
// by voxel. Sink: constant(cell, layer, probe-made label) and mixed(i, j, k, active).
template <class Sink>
class CellWalk {
 public:
  /// `margin`: how far beyond a voxel an outline still counts in it, mm.
  CellWalk(const PosedParts& parts, const Grid& grid, Sink& sink, double margin)
      : parts_(parts), grid_(grid), sink_(sink), margin_(margin) {}

  void visit(Cell cell, const LocalFields* local = nullptr, double local_radius = 1e9) {
    Vec3 middle, half;
    for (std::size_t a = 0; a < 3; ++a) {
      const int ia = static_cast<int>(a);
      middle[ia] = 0.5 * (cell.from[a] + cell.to[a] - 1);
      half[ia] = 0.5 * (cell.to[a] - cell.from[a]) * grid_.spacing[ia];
    }
    const double radius = length(half);
    const Vec3 centre = grid_.to_patient(middle);
    TissueProbe probe(parts_, centre, local);
    std::uint32_t still = 0;
    for (int l = 0; l < layer_count; ++l) {
      if ((cell.active >> l & 1) == 0) continue;
      const double outline = probe.outline(l), reach = probe.lipschitz(l, radius) * radius + margin_;
      if (outline > reach) continue;
      if (outline < -reach) {
        // Later layers lie under this one; earlier ones, where still undecided, over it.
        if (still == 0) return sink_.constant(cell, l, probe, radius);
        still |= 1u << l;
        break;
      }
      still |= 1u << l;
    }
    cell.active = still;
    const bool single =
        cell.to[0] - cell.from[0] == 1 && cell.to[1] - cell.from[1] == 1 && cell.to[2] - cell.from[2] == 1;
    const bool divided = !single || sink_.divides(radius);
    if (!divided || radius > largest_local || radius > 0.6 * local_radius) {
      return single ? sink_.mixed(cell.from, still, probe, local) : split(cell, local, local_radius);
    }
    // Fields of the cell's own, for all that lies in it.
    LocalFields own;
    const std::uint32_t needed = TissueProbe::parts_of(still);
    for (std::size_t i = 0; i < part_count; ++i) {
      if ((needed >> i & 1) != 0)
        parts_.add_local(own, static_cast<Part>(i), centre, half, sink_.tolerance(), local);
    }
    if (single) return sink_.mixed(cell.from, still, probe, &own);
    split(cell, &own, radius);
  }

 private:
  void split(const Cell& cell, const LocalFields* local, double local_radius) {
    Index3 middle{};
    for (std::size_t a = 0; a < 3; ++a) middle[a] = (cell.from[a] + cell.to[a] + 1) / 2;
    for (int child = 0; child < 8; ++child) {
      Cell part = cell;
      bool empty = false;
      for (std::size_t a = 0; a < 3; ++a) {
        if (child >> a & 1) {
          part.from[a] = middle[a];
        } else {
          part.to[a] = middle[a];
        }
        empty = empty || part.from[a] >= part.to[a];
      }
      if (!empty) visit(part, local, local_radius);
    }
  }

  const PosedParts& parts_;
  const Grid& grid_;
  Sink& sink_;
  double margin_;
};

/// Hounsfield numbers by supersampling: mixed voxels are divided like the cells above them, down to small
/// boxes of 2 × 2 × 2 samples, in each of which the layers cover by the distance of their outline.
class HounsfieldSink {
 public:
  HounsfieldSink(const PosedParts& parts, const Grid& grid, std::vector<float>& out)
      : parts_(parts),
        grid_(grid),
        out_(out),
        largest_box_(std::max(1.2, 0.5 * std::min(grid.spacing.x, grid.spacing.z))) {}

  /// Half a sample's width: so far beyond its centre an outline counts in a sample.
  [[nodiscard]] double margin() const { return 0.25 * largest_box_; }
  /// By how much an outline may be off, mm: a fiftieth of a voxel.
  [[nodiscard]] double tolerance() const {
    return 0.02 * std::min({grid_.spacing.x, grid_.spacing.y, grid_.spacing.z});
  }
  /// Voxels of this radius are taken apart.
  [[nodiscard]] bool divides(double radius) const { return radius > largest_box_; }
  void constant(const Cell& cell, int layer, TissueProbe&, double) {
    const auto value = static_cast<float>(TissueProbe::layers[static_cast<std::size_t>(layer)].hounsfield);
    for (int k = cell.from[2]; k < cell.to[2]; ++k) {
      for (int j = cell.from[1]; j < cell.to[1]; ++j) {
        const std::size_t row = grid_.offset(0, j, k);
        std::fill(out_.begin() + static_cast<std::ptrdiff_t>(row) + cell.from[0],
                  out_.begin() + static_cast<std::ptrdiff_t>(row) + cell.to[0], value);
      }
    }
  }
  void mixed(const Index3& voxel, std::uint32_t active, TissueProbe& probe, const LocalFields* local) {
    const Vec3 middle{static_cast<double>(voxel[0]), static_cast<double>(voxel[1]),
                      static_cast<double>(voxel[2])};
    out_[grid_.offset(voxel[0], voxel[1], voxel[2])] =
        static_cast<float>(mean(grid_.to_patient(middle), grid_.spacing, active, probe, local));
  }

 private:
  using Outlines = std::array<double, layer_count>;

  // Mean over a box with `active` layers, `probe` at its middle.
  double mean(const Vec3& middle, const Vec3& size, std::uint32_t active, TissueProbe& probe,
              const LocalFields* local) const {
    if (std::max({size.x, size.y, size.z}) <= largest_box_)
      return eighths(middle, size, active, probe, local);
    Index3 parts{};
    Vec3 part = size;
    for (std::size_t a = 0; a < 3; ++a) {
      parts[a] = size[static_cast<int>(a)] > largest_box_ ? 2 : 1;
      part[static_cast<int>(a)] /= parts[a];
    }
    double sum = 0;
    for (int k = 0; k < parts[2]; ++k) {
      for (int j = 0; j < parts[1]; ++j) {
        for (int i = 0; i < parts[0]; ++i) {
          const Vec3 at =
              middle - size * 0.5 + Vec3{(i + 0.5) * part.x, (j + 0.5) * part.y, (k + 0.5) * part.z};
          sum += narrowed(at, part, active, local);
        }
      }
    }
    return sum / (parts[0] * parts[1] * parts[2]);
  }

  // The same, once the layers that do not reach the box are dropped.
  double narrowed(const Vec3& middle, const Vec3& size, std::uint32_t active,
                  const LocalFields* local) const {
    TissueProbe probe(parts_, middle, local);
    const double radius = 0.5 * length(size);
    std::uint32_t still = 0;
    for (int l = 0; l < layer_count; ++l) {
      if ((active >> l & 1) == 0) continue;
      const double outline = probe.outline(l), reach = probe.lipschitz(l, radius) * radius + margin();
      if (outline > reach) continue;
      if (outline < -reach && still == 0) return TissueProbe::layers[static_cast<std::size_t>(l)].hounsfield;
      still |= 1u << l;
      if (outline < -reach) break;
    }
    return mean(middle, size, still, probe, local);
  }

  // The mean of 2 × 2 × 2 samples. Four of them, a tetrahedron, fix a linear outline; where the middle of the
  // box agrees with it the other four follow, else they are evaluated.
  double eighths(const Vec3& middle, const Vec3& size, std::uint32_t active, TissueProbe& centre,
                 const LocalFields* local) const {
    constexpr std::array<Index3, 4> corners{{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}};
    const double width = 0.5 * std::cbrt(size.x * size.y * size.z);
    const auto offset = [&](const Index3& c) {
      return Vec3{0.25 * size.x * c[0], 0.25 * size.y * c[1], 0.25 * size.z * c[2]};
    };
    std::array<Outlines, 4> at;
    Outlines centroid{};
    double sum = 0;
    for (std::size_t c = 0; c < 4; ++c) {
      at[c] = outlines(middle + offset(corners[c]), active, local);
      for (std::size_t l = 0; l < layer_count; ++l) centroid[l] += 0.25 * at[c][l];
      sum += covered(at[c], active, width);
    }
    bool straight = true;
    for (int l = 0; l < layer_count; ++l) {
      if ((active >> l & 1) == 0) continue;
      straight =
          straight && std::abs(centroid[static_cast<std::size_t>(l)] - centre.outline(l)) < 0.02 * width;
    }
    for (std::size_t c = 0; c < 4; ++c) {
      Outlines opposite;
      if (straight) {
        for (std::size_t l = 0; l < layer_count; ++l) opposite[l] = 2 * centroid[l] - at[c][l];
      } else {
        opposite = outlines(middle - offset(corners[c]), active, local);
      }
      sum += covered(opposite, active, width);
    }
    return sum / 8;
  }
  Outlines outlines(const Vec3& p, std::uint32_t active, const LocalFields* local) const {
    TissueProbe probe(parts_, p, local);
    Outlines values{};
    for (int l = 0; l < layer_count; ++l) {
      if ((active >> l & 1) != 0) values[static_cast<std::size_t>(l)] = probe.outline(l);
    }
    return values;
  }
  [[nodiscard]] static double covered(const Outlines& outline, std::uint32_t active, double width) {
    double value = 0, open = 1;
    for (std::size_t l = 0; l < layer_count && open > 0; ++l) {
      if ((active >> l & 1) == 0) continue;
      const double cover = open * std::clamp(0.5 - outline[l] / width, 0.0, 1.0);
      value += cover * TissueProbe::layers[l].hounsfield;
      open -= cover;
    }
    return value + open * TissueProbe::layers.back().hounsfield;
  }

  const PosedParts& parts_;
  const Grid& grid_;
  std::vector<float>& out_;
  double largest_box_;
};

struct LabelSink {
  const PosedParts& parts;
  const Grid& grid;
  std::vector<std::uint8_t>& out;

  [[nodiscard]] static double margin() { return 0; }
  [[nodiscard]] static double tolerance() { return 0; }  // labels are exact
  [[nodiscard]] static bool divides(double) { return false; }
  void constant(const Cell& cell, int layer, TissueProbe& probe, double radius) {
    // One layer, but perhaps of two labels (skull and mandible side by side): then voxel by voxel.
    const bool varies = !probe.same_label(layer, radius);
    const auto whole = static_cast<std::uint8_t>(probe.label(layer));
    for (int k = cell.from[2]; k < cell.to[2]; ++k) {
      for (int j = cell.from[1]; j < cell.to[1]; ++j) {
        for (int i = cell.from[0]; i < cell.to[0]; ++i) {
          if (!varies) {
            out[grid.offset(i, j, k)] = whole;
            continue;
          }
          TissueProbe own(parts, grid.to_patient({1.0 * i, 1.0 * j, 1.0 * k}));
          mixed({i, j, k}, 1u << layer, own, nullptr);
        }
      }
    }
  }
  // The probe lies at the voxel's centre.
  void mixed(const Index3& voxel, std::uint32_t active, TissueProbe& probe, const LocalFields*) const {
    PhantomLabel label = PhantomLabel::air;
    for (int l = 0; l < layer_count; ++l) {
      if ((active >> l & 1) == 0 || probe.outline(l) >= 0) continue;
      label = probe.label(l);
      break;
    }
    out[grid.offset(voxel[0], voxel[1], voxel[2])] = static_cast<std::uint8_t>(label);
  }
};

template <class Sink>
Result<void> walk(const PosedParts& parts, const Grid& grid, Sink& sink, Context& context) {
  const int slabs = (grid.size[2] + block - 1) / block, rows = (grid.size[1] + block - 1) / block;
  CellWalk<Sink> cells(parts, grid, sink, sink.margin());
  std::atomic<int> done = 0;
  parallel_for(static_cast<std::size_t>(slabs * rows), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      if (context.cancelled()) return;
      const int k = static_cast<int>(r) / rows * block, j = static_cast<int>(r) % rows * block;
      for (int i = 0; i < grid.size[0]; i += block) {
        cells.visit({{i, j, k},
                     {std::min(i + block, grid.size[0]), std::min(j + block, grid.size[1]),
                      std::min(k + block, grid.size[2])},
                     (1u << layer_count) - 1});
      }
      context.progress(static_cast<double>(++done) / (slabs * rows));
    }
  });
  return context.check();
}

std::vector<float> gaussian_taps(double sigma_in_voxels) {
  const int reach = static_cast<int>(std::ceil(3.5 * sigma_in_voxels));
  std::vector<double> taps;
  for (int i = -reach; i <= reach; ++i) {
    // The tap is the Gaussian's share of the voxel, so that narrow kernels keep their width.
    const double a = (i - 0.5) / sigma_in_voxels, b = (i + 0.5) / sigma_in_voxels;
    taps.push_back(0.5 * (std::erf(b / std::numbers::sqrt2) - std::erf(a / std::numbers::sqrt2)));
  }
  const double total = std::accumulate(taps.begin(), taps.end(), 0.0);
  std::vector<float> out;
  out.reserve(taps.size());
  for (const double t : taps) out.push_back(static_cast<float>(t / total));
  return out;
}

// One line of `count` groups of `width` neighbouring values, `stride` apart, blurred in place with clamped
// ends.
void blur_lines(float* data, int count, std::size_t stride, std::size_t width, const std::vector<float>& taps,
                std::vector<float>& copy) {
  const int reach = static_cast<int>(taps.size()) / 2;
  copy.resize(static_cast<std::size_t>(count) * width);
  for (int i = 0; i < count; ++i) {
    std::copy_n(data + static_cast<std::size_t>(i) * stride, width,
                copy.data() + static_cast<std::size_t>(i) * width);
  }
  for (int i = 0; i < count; ++i) {
    float* to = data + static_cast<std::size_t>(i) * stride;
    std::fill_n(to, width, 0.0f);
    for (int t = -reach; t <= reach; ++t) {
      const float tap = taps[static_cast<std::size_t>(t + reach)];
      const float* from = copy.data() + static_cast<std::size_t>(std::clamp(i + t, 0, count - 1)) * width;
      for (std::size_t w = 0; w < width; ++w) to[w] += tap * from[w];
    }
  }
}

void blur(std::vector<float>& values, const Grid& grid, double sigma_mm) {
  const auto nx = static_cast<std::size_t>(grid.size[0]), ny = static_cast<std::size_t>(grid.size[1]),
             nz = static_cast<std::size_t>(grid.size[2]);
  const auto along_x = gaussian_taps(sigma_mm / grid.spacing.x),
             along_y = gaussian_taps(sigma_mm / grid.spacing.y),
             along_z = gaussian_taps(sigma_mm / grid.spacing.z);
  parallel_for(nz, 4, [&](std::size_t begin, std::size_t end) {
    std::vector<float> copy;
    for (std::size_t k = begin; k < end; ++k) {
      float* slice = values.data() + k * nx * ny;
      for (std::size_t j = 0; j < ny; ++j) blur_lines(slice + j * nx, grid.size[0], 1, 1, along_x, copy);
      blur_lines(slice, grid.size[1], nx, nx, along_y, copy);
    }
  });
  parallel_for(ny, 4, [&](std::size_t begin, std::size_t end) {
    std::vector<float> copy;
    for (std::size_t j = begin; j < end; ++j) {
      blur_lines(values.data() + j * nx, grid.size[2], nx * ny, nx, along_z, copy);
    }
  });
}

Grid scan_grid(const PhantomParameters& parameters) {
  const Box3 box = scan_extent(parameters);
  Grid grid;
  grid.spacing = {parameters.voxel_mm, parameters.voxel_mm, parameters.slice_mm};
  for (int a = 0; a < 3; ++a) {
    grid.size[static_cast<std::size_t>(a)] = static_cast<int>(std::ceil(box.size()[a] / grid.spacing[a]));
  }
  grid.origin = box.lower + grid.spacing * 0.5;
  return grid;
}

}  // namespace

Result<CtVolume> scan(const PosedParts& parts, Context& context) {
  const PhantomParameters& parameters = parts.parameters();
  const Stage stage(context, "Scanning the phantom");
  const Grid grid = scan_grid(parameters);
  std::vector<float> values(grid.voxel_count());
  HounsfieldSink sink(parts, grid, values);
  TURGOR_CHECK(walk(parts, grid, sink, context));
  if (parameters.blur_mm > 0) blur(values, grid, parameters.blur_mm);
  TURGOR_CHECK(context.check());
  CtVolume volume(grid);
  const RandomStream random(parameters.seed, 0x5CA7);
  parallel_for(values.size(), 1 << 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const double noise = parameters.noise_hu > 0 ? parameters.noise_hu * random.normal(v) : 0;
      volume.voxels[v] =
          static_cast<std::int16_t>(std::lround(std::clamp(values[v] + noise, -1024.0, 3071.0)));
    }
  });
  return volume;
}

Result<LabelVolume> labels(const PosedParts& parts, const Grid& grid, Context& context) {
  const Stage stage(context, "Labelling the phantom");
  LabelVolume volume(grid);
  LabelSink sink{parts, grid, volume.voxels};
  TURGOR_CHECK(walk(parts, grid, sink, context));
  return volume;
}

}  // namespace turgor::phantom
