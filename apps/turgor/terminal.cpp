#include "terminal.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <string>

namespace turgor {
namespace {

using Clock = std::chrono::steady_clock;

std::atomic<bool> stop_asked{false};
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void ask_to_stop(int signal) {
  if (stop_asked.exchange(true)) {
    // Asked twice: do as other programs do.
    ::signal(signal, SIG_DFL);
    ::raise(signal);
  }
}

// One line that is redrawn on a terminal; elsewhere a line for each stage as it begins.
class ProgressLine {
 public:
  void show(std::string_view stage, double fraction) {
    if (stage.empty()) return;
    if (stage != stage_) begin(stage);
    if (!terminal_) return;
    const auto now = Clock::now();
    if (fraction < 1 && now - drawn_ < std::chrono::milliseconds(80)) return;
    drawn_ = now;
    const double spent = std::chrono::duration<double>(now - started_).count();
    std::string left;
    if (fraction > 0.05 && fraction < 1 && spent > 0.5)
      left = fmt::format(", {:.0f} s left", spent / fraction - spent);
    fmt::print(stderr, "\r\033[K{} {:3.0f} %{}", stage, 100 * fraction, left);
    open_ = true;
    if (fraction >= 1) clear();
    std::fflush(stderr);
  }
  void print(const Notice& notice) {
    clear();
    fmt::print(stderr, "{}{}\n", notice.severity == Severity::warning ? "warning: " : "", notice.text);
  }
  void clear() {
    if (open_) fmt::print(stderr, "\r\033[K");
    open_ = false;
  }

 private:
  void begin(std::string_view stage) {
    stage_ = stage;
    started_ = Clock::now();
    if (!terminal_) fmt::print(stderr, "{} ...\n", stage);
  }

  const bool terminal_ = ::isatty(STDERR_FILENO) != 0;
  std::string stage_;
  Clock::time_point started_, drawn_;
  bool open_ = false;
};

}  // namespace

std::unique_ptr<Context> make_terminal_context() {
  struct sigaction action {};
  action.sa_handler = ask_to_stop;
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  auto line = std::make_shared<ProgressLine>();
  return std::make_unique<Context>([line](std::string_view stage, double f) { line->show(stage, f); },
                                   [line](const Notice& n) { line->print(n); },
                                   [] { return stop_asked.load(); });
}

int fail(const Error& error) {
  if (::isatty(STDERR_FILENO) != 0) fmt::print(stderr, "\r\033[K");
  fmt::print(stderr, "turgor: {}\n", error.message());
  return error.exit_code();
}

}  // namespace turgor
