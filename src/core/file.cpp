#include "turgor/core/file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

namespace turgor {
namespace fs = std::filesystem;
namespace {

class FileDescriptor {
 public:
  explicit FileDescriptor(int fd) : fd_(fd) {}
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  ~FileDescriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  [[nodiscard]] int get() const { return fd_; }
  /// Closes now and tells whether buffered data reached the file.
  bool close() { return ::close(std::exchange(fd_, -1)) == 0; }

 private:
  int fd_;
};

Error system_error(const fs::path& path, const std::string& what, int code) {
  std::string remedy = "Check the path and its permissions";
  if (code == ENOSPC || code == EDQUOT) remedy = "The disk is full: free some space or choose another folder";
  if (code == ENOENT) remedy = "Check the spelling of the path";
  return {ErrorKind::system, what + " (" + std::strerror(code) + ")", path.string(), remedy};
}

}  // namespace

Result<std::vector<std::byte>> read_file(const fs::path& path, std::uint64_t max_bytes) {
  // A named pipe would wait here for somebody to write into it; what is not a regular file is refused below.
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.get() < 0) {
    const int code = errno;
    if (code == ENOENT)
      return Error{ErrorKind::bad_input, "no such file or folder", path.string(),
                   "Check the spelling of the path"};
    return system_error(path, "cannot be opened", code);
  }
  struct stat info {};
  if (::fstat(file.get(), &info) != 0) return system_error(path, "cannot be read", errno);
  if (!S_ISREG(info.st_mode)) {
    return Error{ErrorKind::bad_input,
                 S_ISDIR(info.st_mode) ? "is a folder, not a file" : "is a pipe or a device, not a file",
                 path.string(), "Name a file"};
  }
  const auto size = static_cast<std::uint64_t>(info.st_size);
  if (size > max_bytes) {
    return Error{ErrorKind::bad_input,
                 "is larger than the " + std::to_string(max_bytes >> 20) + " MiB accepted here",
                 path.string(), "Name a smaller file"};
  }
  std::vector<std::byte> bytes(size);
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t got = ::read(file.get(), bytes.data() + done, bytes.size() - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return system_error(path, "cannot be read", errno);
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  bytes.resize(done);
  return bytes;
}

Result<std::string> read_text_file(const fs::path& path, std::uint64_t max_bytes) {
  TURGOR_TRY(const auto bytes, read_file(path, max_bytes));
  return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

Result<void> write_file(const fs::path& path, std::span<const std::byte> bytes) {
  const fs::path temporary = path.string() + ".part" + std::to_string(::getpid());
  FileDescriptor file(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
  if (file.get() < 0) return system_error(path, "cannot be written", errno);
  const auto fail = [&](int code) {
    ::unlink(temporary.c_str());
    return system_error(path, "cannot be written", code);
  };
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t put = ::write(file.get(), bytes.data() + done, bytes.size() - done);
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return fail(errno);
    done += static_cast<std::size_t>(put);
  }
  if (!file.close()) return fail(errno);
  if (::rename(temporary.c_str(), path.c_str()) != 0) return fail(errno);
  return {};
}

Result<void> write_file(const fs::path& path, std::string_view text) {
  return write_file(path, std::as_bytes(std::span(text.data(), text.size())));
}

StagedFolder::StagedFolder(fs::path target) : target_(std::move(target)) {}

StagedFolder::StagedFolder(StagedFolder&& other) noexcept
    : target_(std::move(other.target_)),
      staging_(std::exchange(other.staging_, {})),
      parents_(std::exchange(other.parents_, {})) {}

StagedFolder::~StagedFolder() {
  std::error_code ignored;
  if (!staging_.empty()) fs::remove_all(staging_, ignored);
  // A parent that has been filled meanwhile stays: remove() takes empty folders only.
  for (auto parent = parents_.rbegin(); parent != parents_.rend(); ++parent) fs::remove(*parent, ignored);
}

Result<void> StagedFolder::make_parents() {
  std::vector<fs::path> missing;
  std::error_code code;
  for (fs::path at = target_.parent_path(); !fs::exists(at, code) && at.has_relative_path();
       at = at.parent_path()) {
    missing.push_back(at);
  }
  for (auto at = missing.rbegin(); at != missing.rend(); ++at) {
    if (fs::create_directory(*at, code)) parents_.push_back(*at);
    if (code) return system_error(*at, "the folder cannot be made", code.value());
  }
  return {};
}

Result<StagedFolder> StagedFolder::create(const fs::path& target) {
  std::error_code code;
  const fs::path absolute = fs::absolute(target, code).lexically_normal();
  if (code) return system_error(target, "has no place, for the working folder is gone", code.value());
  const fs::path clean = absolute.has_filename() ? absolute : absolute.parent_path();
  const fs::file_status status = fs::status(clean, code);
  if (status.type() == fs::file_type::none) return system_error(clean, "cannot be written", code.value());
  const bool exists = fs::exists(status);
  if (exists ? !fs::is_directory(status) : fs::is_symlink(clean, code)) {
    return Error{ErrorKind::bad_input, exists ? "exists and is not a folder" : "is a link to nothing",
                 clean.string(), "Name another output folder"};
  }
  StagedFolder staged(clean);  // what is made from here on, its destructor removes
  TURGOR_CHECK(staged.make_parents());
  // On the disk of the target, which may be one of its own: files are moved, not copied, into place.
  static std::atomic<int> count{0};
  const fs::path staging = (exists ? clean : clean.parent_path()) /
                           (".turgor.part" + std::to_string(::getpid()) + "_" + std::to_string(++count));
  fs::remove_all(staging, code);
  if (fs::create_directory(staging, code); code) {
    return system_error(clean, exists ? "cannot be written" : "the folder cannot be made", code.value());
  }
  staged.staging_ = staging;
  return staged;
}

Result<void> StagedFolder::check_conflicts() const {
  std::error_code code;
  for (fs::recursive_directory_iterator at(staging_, code), end; !code && at != end; at.increment(code)) {
    const fs::path destination = target_ / at->path().lexically_relative(staging_);
    std::error_code ignored;
    if (fs::exists(destination, ignored) && fs::is_directory(destination, ignored) != at->is_directory()) {
      return Error{ErrorKind::bad_input,
                   at->is_directory() ? "is a file where a folder is to be written"
                                      : "is a folder where a file is to be written",
                   destination.string(), "Remove it, or name another output folder"};
    }
  }
  if (code) return system_error(target_, "cannot be written", code.value());
  return {};
}

Result<void> StagedFolder::commit() {
  std::error_code code;
  if (!fs::exists(target_, code)) {
    fs::rename(staging_, target_, code);
    if (code) return system_error(target_, "the folder cannot be made", code.value());
    staging_.clear();
    parents_.clear();
    return {};
  }
  TURGOR_CHECK(check_conflicts());
  for (fs::recursive_directory_iterator at(staging_, code), end; !code && at != end; at.increment(code)) {
    const fs::path destination = target_ / at->path().lexically_relative(staging_);
    if (at->is_directory()) {
      fs::create_directories(destination, code);
    } else {
      fs::rename(at->path(), destination, code);
    }
    if (code) return system_error(destination, "cannot be written", code.value());
  }
  if (code) return system_error(target_, "cannot be written", code.value());
  return {};
}

Error StagedFolder::as_target(Error error) const {
  const std::string hidden = staging_.string();
  if (!hidden.empty() && error.where.starts_with(hidden))
    error.where.replace(0, hidden.size(), target_.string());
  return error;
}

Result<void> check_output_folder(const fs::path& target) {
  TURGOR_TRY(const StagedFolder probe, StagedFolder::create(target));
  return {};
}

Result<void> write_folder(const fs::path& target, const std::function<Result<void>(const fs::path&)>& fill) {
  TURGOR_TRY(StagedFolder staged, StagedFolder::create(target));
  if (const auto filled = fill(staged.path()); !filled) return staged.as_target(filled.error());
  return staged.commit();
}

}  // namespace turgor
