// What a long operation is given to report progress, raise notices, and learn that the user wants to stop.
#pragma once

#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/core/error.hpp"

namespace turgor {

enum class Severity { notice, warning };

struct Notice {
  Severity severity;
  std::string text;
};

/// Wall-clock seconds spent in one named stage.
struct StageTime {
  std::string stage;
  double seconds;
};

/// Progress, notices, timing and cancellation of one run. Passed by reference down the call chain; a default
/// one is silent and is never cancelled. Notices are kept as well as shown, so that reports can list them.
/// Thread-safe: cancelled(), progress() and notices may be called from any thread.
class Context {
 public:
  using Listener = std::function<void(std::string_view stage, double fraction)>;
  using NoticeListener = std::function<void(const Notice&)>;
  using CancelTest = std::function<bool()>;

  Context() = default;
  Context(Listener on_progress, NoticeListener on_notice, CancelTest cancel_test);
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  /// Fraction of the present stage done, 0 to 1.
  void progress(double fraction);
  void notice(std::string text);
  void warning(std::string text);
  [[nodiscard]] bool cancelled() const;
  /// Error of kind `cancelled` when the user asked to stop: `TURGOR_CHECK(context.check());` inside long
  /// loops.
  [[nodiscard]] Result<void> check() const;

  [[nodiscard]] std::vector<Notice> notices() const;
  [[nodiscard]] std::vector<StageTime> stage_times() const;

 private:
  friend class Stage;
  void enter(std::string name);
  void leave(const std::string& name, double seconds);

  Listener on_progress_;
  NoticeListener on_notice_;
  CancelTest cancel_test_;
  mutable std::mutex mutex_;
  std::vector<std::string> open_stages_;
  std::vector<StageTime> times_;
  std::vector<Notice> notices_;
};

/// Names a stage of the work for as long as it lives and records its duration.
class Stage {
 public:
  Stage(Context& context, std::string name);
  ~Stage();
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

 private:
  Context& context_;
  std::string name_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace turgor
