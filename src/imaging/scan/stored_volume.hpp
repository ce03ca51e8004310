// What the reader of each format hands to the last step that all share: voxels as stored, and where they lie.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "turgor/imaging/scan.hpp"

namespace turgor::scan_io {

/// Hounsfield number given to voxels without a value (outside a sheared stack, not-a-number).
inline constexpr std::int16_t kAirHu = -1024;
/// No scan accepted is larger; 4 Gi voxels are 8 GiB.
inline constexpr std::uint64_t kMaxVoxels = std::uint64_t{4} << 30;

/// The file being read: `bytes` for the parser, `path` for messages and for files beside it.
struct SourceFile {
  std::filesystem::path path;
  std::span<const std::byte> bytes;
};

/// Voxels that had no exact place in 16-bit Hounsfield units.
struct ValueLosses {
  std::size_t clamped = 0;     ///< beyond -32768..32767
  std::size_t not_finite = 0;  ///< became air
  ValueLosses& operator+=(const ValueLosses& other) {
    clamped += other.clamped;
    not_finite += other.not_finite;
    return *this;
  }
};

/// Patient point of stored index (i, j, k) = origin + i axes[0] + j axes[1] + k axes[2], LPS mm. The axes may
/// be in any order, of either handedness, and sheared.
struct StoredVolume {
  Index3 size{1, 1, 1};
  Vec3 origin{};
  std::array<Vec3, 3> axes{};
  std::vector<std::int16_t> voxels;
  ValueLosses losses;
  ScanInfo info;
};

/// Error of kind bad_input at a file.
Error bad_file(const std::filesystem::path& path, std::string what, std::string remedy);

/// Errors: a size below 1, a product beyond kMaxVoxels.
Result<Index3> checked_size(const std::array<std::int64_t, 3>& size, const std::filesystem::path& path);
std::size_t voxel_count(const Index3& size);

/// Right-handed LPS: axes permuted and flipped to i ≈ +L, j ≈ +P, k ≈ +S, values moved without interpolation;
/// a sheared stack (gantry tilt) is resampled trilinearly onto an orthogonal grid that covers it, with the
/// rows of the stored one, air outside; labels by the nearest voxel, 0 outside. Warns of lost values. Errors:
/// axes without length, not finite or nearly parallel; fewer than 2 voxels along an axis; labels that were
/// lost.
Result<Scan> to_canonical(StoredVolume stored, const std::filesystem::path& path, Context& context,
                          bool labels = false);

}  // namespace turgor::scan_io
