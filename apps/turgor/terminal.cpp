#include "terminal.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <map>
#include <string>

namespace turgor {
namespace {

using Clock = std::chrono::steady_clock;

std::atomic<bool> stop_asked{false};
static_assert(std::atomic<bool>::is_always_lock_free);

std::atomic<int> nothing_at_stake{0};
static_assert(std::atomic<int>::is_always_lock_free);

// Only what a signal handler may call.
void stop_at_once() {
  static constexpr char wipe[] = "\r\033[K";
  static constexpr char text[] = "turgor: stopped on request; nothing was written.\n";
  ssize_t written = 0;
  if (::isatty(STDERR_FILENO) != 0) written = ::write(STDERR_FILENO, wipe, sizeof wipe - 1);
  written = ::write(STDERR_FILENO, text, sizeof text - 1);
  static_cast<void>(written);
  ::_exit(Error{ErrorKind::cancelled, {}, {}, {}}.exit_code());
}

extern "C" void ask_to_stop(int signal) {
  if (nothing_at_stake > 0) stop_at_once();
  if (stop_asked.exchange(true)) {
    // Asked twice: do as other programs do.
    ::signal(signal, SIG_DFL);
    ::raise(signal);
  }
}

int terminal_columns() {
  winsize size{};
  const bool known = ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : 80;
}

// One line that is redrawn on a terminal; elsewhere a line for each stage as it begins. Stages nest, and the
// outer one goes on where an inner one ends: it is not announced again, and keeps its clock.
class ProgressLine {
 public:
  void show(std::string_view stage, double fraction) {
    if (stage.empty()) return;
    const auto now = Clock::now();
    const auto [begun, is_new] = begun_.try_emplace(capitalised(stage), now);
    if (!terminal_) {
      if (is_new) fmt::print(stderr, "{} ...\n", begun->first);
      return;
    }
    if (fraction >= 1) begun_.erase(begun), clear();
    const bool just_drawn = stage == drawn_stage_ && now - drawn_ < std::chrono::milliseconds(80);
    if (fraction >= 1 || just_drawn) return;
    drawn_ = now;
    drawn_stage_ = stage;
    draw(begun->first, fraction, std::chrono::duration<double>(now - begun->second).count());
  }
  void print(const Notice& notice) {
    clear();
    fmt::print(stderr, "{}{}\n", notice.severity == Severity::warning ? "warning: " : "", notice.text);
  }

 private:
  static std::string capitalised(std::string_view stage) {
    std::string text(stage);
    if (text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
    return text;
  }
  void draw(const std::string& stage, double fraction, double spent) {
    std::string line = fmt::format("{} {:3.0f} %", stage, 100 * fraction);
    if (fraction > 0.05 && spent > 0.5) line += fmt::format(", {:.0f} s left", spent / fraction - spent);
    // A line that wraps cannot be wiped.
    line.resize(std::min(line.size(), static_cast<std::size_t>(terminal_columns() - 1)));
    fmt::print(stderr, "\r\033[K{}", line);
    std::fflush(stderr);
    open_ = true;
  }
  void clear() {
    if (open_) fmt::print(stderr, "\r\033[K");
    open_ = false;
  }

  const bool terminal_ = ::isatty(STDERR_FILENO) != 0;
  std::map<std::string, Clock::time_point> begun_;
  Clock::time_point drawn_;
  std::string drawn_stage_;
  bool open_ = false;
};

}  // namespace

StopAtOnce::StopAtOnce() {
  ++nothing_at_stake;
  // Asked for just before: the handler has left it to the work, which is not going to ask.
  if (stop_asked) stop_at_once();
}

StopAtOnce::~StopAtOnce() {
  --nothing_at_stake;
}

std::unique_ptr<Context> make_terminal_context() {
  struct sigaction action {};
  action.sa_handler = ask_to_stop;
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  ::sigaction(SIGHUP, &action, nullptr);
  auto line = std::make_shared<ProgressLine>();
  return std::make_unique<Context>([line](std::string_view stage, double f) { line->show(stage, f); },
                                   [line](const Notice& n) { line->print(n); },
                                   [] { return stop_asked.load(); });
}

bool take_stop_request() {
  return stop_asked.exchange(false);
}

int fail(const Error& error) {
  if (::isatty(STDERR_FILENO) != 0) fmt::print(stderr, "\r\033[K");
  fmt::print(stderr, "turgor: {}\n", error.message());
  return error.exit_code();
}

}  // namespace turgor
