// Small helpers for the text headers of NRRD and MetaImage, and for data that lie beside or behind them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "imaging/scan/scalars.hpp"
#include "turgor/core/lower_case.hpp"

namespace turgor::scan_io {

std::string_view trimmed(std::string_view text);
std::vector<std::string_view> words(std::string_view text);
/// All words as finite numbers; nullopt if one is not.
std::optional<std::vector<double>> numbers(std::string_view text);
/// The same as whole numbers.
std::optional<std::vector<std::int64_t>> whole_numbers(std::string_view text);

/// Lines of a header, without their ends (LF or CR LF).
class LineReader {
 public:
  explicit LineReader(std::span<const std::byte> bytes)
      : text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()) {}
  /// nullopt at the end of the bytes.
  std::optional<std::string_view> next();
  /// Bytes read so far.
  [[nodiscard]] std::size_t position() const { return at_; }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
};

/// The path of a data file named in a header: beside the header unless absolute.
std::filesystem::path beside(const std::filesystem::path& header, std::string_view name);

enum class DataEncoding { raw, gzip, ascii };

/// How the voxels of a header are stored in `bytes`.
struct DataBlock {
  std::filesystem::path path;  ///< of the file that holds them, for messages
  DataEncoding encoding = DataEncoding::raw;
  ScalarFormat format;
  std::int64_t skip =
      0;  ///< bytes before the first voxel, after decompression; -1: the voxels end the file (raw)
};

/// Fills stored.voxels (stored.size must be checked). Errors: too few bytes, damaged compression, not
/// numbers.
Result<void> read_voxels(std::span<const std::byte> bytes, const DataBlock& block, StoredVolume& stored,
                         const Context& context);

}  // namespace turgor::scan_io
