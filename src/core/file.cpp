#include "turgor/core/file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

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
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
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
                 S_ISDIR(info.st_mode) ? "is a folder, not a file" : "is not a regular file", path.string(),
                 "Name a file"};
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

StagedFolder::StagedFolder(fs::path target, fs::path staging)
    : target_(std::move(target)), staging_(std::move(staging)) {}

StagedFolder::StagedFolder(StagedFolder&& other) noexcept
    : target_(std::move(other.target_)), staging_(std::exchange(other.staging_, {})) {}

StagedFolder::~StagedFolder() {
  std::error_code ignored;
  if (!staging_.empty()) fs::remove_all(staging_, ignored);
}

Result<StagedFolder> StagedFolder::create(const fs::path& target) {
  std::error_code code;
  const fs::path absolute = fs::absolute(target, code).lexically_normal();
  fs::path clean = absolute.has_filename() ? absolute : absolute.parent_path();
  if (fs::exists(clean, code) && !fs::is_directory(clean, code)) {
    return Error{ErrorKind::bad_input, "exists and is not a folder", clean.string(),
                 "Name another output folder"};
  }
  if (fs::create_directories(clean.parent_path(), code); code) {
    return system_error(clean.parent_path(), "the folder cannot be made", code.value());
  }
  fs::path staging =
      clean.parent_path() / ("." + clean.filename().string() + ".part" + std::to_string(::getpid()));
  fs::remove_all(staging, code);
  if (fs::create_directory(staging, code); code) {
    return system_error(staging, "the folder cannot be made", code.value());
  }
  return StagedFolder(std::move(clean), std::move(staging));
}

Result<void> StagedFolder::commit() {
  std::error_code code;
  if (!fs::exists(target_, code)) {
    fs::rename(staging_, target_, code);
    if (code) return system_error(target_, "the folder cannot be made", code.value());
    staging_.clear();
    return {};
  }
  for (const auto& entry : fs::recursive_directory_iterator(staging_, code)) {
    const fs::path destination = target_ / fs::relative(entry.path(), staging_);
    if (entry.is_directory()) {
      fs::create_directories(destination, code);
    } else {
      fs::rename(entry.path(), destination, code);
    }
    if (code) return system_error(destination, "cannot be written", code.value());
  }
  if (code) return system_error(target_, "cannot be written", code.value());
  return {};
}

}  // namespace turgor
