#include "render/scene/child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>

namespace turgor::render_detail {
namespace {

constexpr int look_up_ms = 100;               // how often a cancelled run is noticed
constexpr std::size_t most_kept = 64 * 1024;  // of what the child complains

struct Pipe {
  int read_end = -1, write_end = -1;

  Pipe() {
    std::array<int, 2> ends{-1, -1};
    if (::pipe2(ends.data(), O_CLOEXEC) == 0) read_end = ends[0], write_end = ends[1];
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  ~Pipe() {
    close_write();
    if (read_end >= 0) ::close(read_end);
  }
  void close_write() {
    if (write_end >= 0) ::close(write_end);
    write_end = -1;
  }
};

Error cannot_start(const std::string& program, int code) {
  return {ErrorKind::system, std::string("the program cannot be started: ") + std::strerror(code), program,
          "Close other programs or repair its installation"};
}

/// posix_spawnp with the streams set up; its error number, 0 on success.
int spawn(const std::vector<std::string>& arguments, int error_stream, pid_t& child) {
  std::vector<char*> argv;
  argv.reserve(arguments.size() + 1);
  for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  if (const int code = ::posix_spawn_file_actions_init(&actions)) return code;
  int code = ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  if (code == 0) code = ::posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  if (code == 0) code = ::posix_spawn_file_actions_adddup2(&actions, error_stream, STDERR_FILENO);
  if (code == 0) code = ::posix_spawnp(&child, argv[0], &actions, nullptr, argv.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  return code;
}

/// Reads until the child closes its error stream. False when the context was cancelled.
bool listen(int stream, std::string& text, const Context& context) {
  std::array<char, 4096> buffer{};
  while (true) {
    if (context.cancelled()) return false;
    pollfd ready{stream, POLLIN, 0};
    const int count = ::poll(&ready, 1, look_up_ms);
    if (count == 0 || (count < 0 && errno == EINTR)) continue;
    const ssize_t got = ::read(stream, buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return true;
    text.append(buffer.data(), static_cast<std::size_t>(got));
    if (text.size() > most_kept) text.erase(0, text.size() - most_kept);
  }
}

int wait_for(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return 127;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

std::string last_line(const std::string& text) {
  const std::size_t end = text.find_last_not_of(" \t\r\n");
  if (end == std::string::npos) return {};
  const std::size_t before = text.find_last_of("\r\n", end);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  return text.substr(begin, end + 1 - begin);
}

}  // namespace

Result<std::optional<ChildResult>> run_program(const std::vector<std::string>& arguments, Context& context) {
  Pipe complaints;
  if (complaints.read_end < 0) return cannot_start(arguments.front(), errno);
  pid_t child = -1;
  const int code = spawn(arguments, complaints.write_end, child);
  if (code == ENOENT || code == EACCES || code == ENOTDIR) return std::optional<ChildResult>{};
  if (code != 0) return cannot_start(arguments.front(), code);
  complaints.close_write();
  std::string text;
  const bool finished = listen(complaints.read_end, text, context);
  if (!finished) ::kill(child, SIGKILL);
  ChildResult result;
  result.exit_code = wait_for(child);
  TURGOR_CHECK(context.check());
  result.last_complaint = last_line(text);
  return std::optional(std::move(result));
}

}  // namespace turgor::render_detail
