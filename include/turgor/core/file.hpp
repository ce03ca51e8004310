// Whole-file reading and writing that never leaves half a file behind.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/core/error.hpp"

namespace turgor {

/// The bytes of a regular file. Errors: no such path, a folder, unreadable, larger than `max_bytes`.
Result<std::vector<std::byte>> read_file(const std::filesystem::path& path,
                                         std::uint64_t max_bytes = std::uint64_t{8} << 30);
Result<std::string> read_text_file(const std::filesystem::path& path, std::uint64_t max_bytes = 64 << 20);

/// Writes beside `path` and renames into place, so that `path` is either the old file or the whole new one.
/// Errors (disk full, permission) remove the temporary file.
Result<void> write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);
Result<void> write_file(const std::filesystem::path& path, std::string_view text);

/// A folder that appears at `target` only when commit() succeeds; until then all is written to a sibling that
/// the destructor removes. Files already in `target` stay, unless the new ones replace them.
class StagedFolder {
 public:
  static Result<StagedFolder> create(const std::filesystem::path& target);
  StagedFolder(StagedFolder&& other) noexcept;
  StagedFolder& operator=(StagedFolder&&) = delete;
  StagedFolder(const StagedFolder&) = delete;
  ~StagedFolder();

  /// Where to write until commit().
  [[nodiscard]] const std::filesystem::path& path() const { return staging_; }
  Result<void> commit();

 private:
  StagedFolder(std::filesystem::path target, std::filesystem::path staging);
  std::filesystem::path target_, staging_;
};

}  // namespace turgor
