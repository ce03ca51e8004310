// Whole-file reading and writing that never leaves half a file behind.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
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

/// A folder that appears at `target` only when commit() succeeds; until then all is written to a hidden
/// folder (beside `target`, or in it where it exists) that the destructor removes, as it does parents that
/// had to be made. Files already in `target` stay, unless the new ones replace them.
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
  /// The error with the place that the user knows, where it names one in path().
  [[nodiscard]] Error as_target(Error error) const;

 private:
  explicit StagedFolder(std::filesystem::path target);
  Result<void> make_parents();
  /// Before anything is moved: files where folders are to be, or folders where files are to be.
  [[nodiscard]] Result<void> check_conflicts() const;

  std::filesystem::path target_, staging_;
  std::vector<std::filesystem::path> parents_;  ///< made for it, outermost first; empty once committed
};

/// What would keep write_folder(target) from its first file, to be asked before long work. Leaves nothing.
Result<void> check_output_folder(const std::filesystem::path& target);
/// Has `fill` write into a staged folder, and commits it. Errors name places in `target`.
Result<void> write_folder(const std::filesystem::path& target,
                          const std::function<Result<void>(const std::filesystem::path&)>& fill);

}  // namespace turgor
