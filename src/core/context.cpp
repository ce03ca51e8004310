#include "turgor/core/context.hpp"

#include <algorithm>
#include <utility>

namespace turgor {

Context::Context(Listener on_progress, NoticeListener on_notice, CancelTest cancel_test)
    : on_progress_(std::move(on_progress)),
      on_notice_(std::move(on_notice)),
      cancel_test_(std::move(cancel_test)) {}

void Context::progress(double fraction) {
  if (!on_progress_) return;
  const std::lock_guard lock(mutex_);
  on_progress_(open_stages_.empty() ? std::string_view{} : open_stages_.back(),
               std::clamp(fraction, 0.0, 1.0));
}

void Context::notice(std::string text) {
  const std::lock_guard lock(mutex_);
  notices_.push_back({Severity::notice, std::move(text)});
  if (on_notice_) on_notice_(notices_.back());
}

void Context::warning(std::string text) {
  const std::lock_guard lock(mutex_);
  notices_.push_back({Severity::warning, std::move(text)});
  if (on_notice_) on_notice_(notices_.back());
}

bool Context::cancelled() const {
  return cancel_test_ && cancel_test_();
}

Result<void> Context::check() const {
  if (cancelled()) return Error{ErrorKind::cancelled, "stopped on request; nothing was written"};
  return {};
}

std::vector<Notice> Context::notices() const {
  const std::lock_guard lock(mutex_);
  return notices_;
}

std::vector<StageTime> Context::stage_times() const {
  const std::lock_guard lock(mutex_);
  return times_;
}

void Context::enter(std::string name) {
  {
    const std::lock_guard lock(mutex_);
    open_stages_.push_back(std::move(name));
  }
  progress(0);
}

void Context::leave(const std::string& name, double seconds) {
  progress(1);
  const std::lock_guard lock(mutex_);
  times_.push_back({name, seconds});
  // Stages nest, so the one that ends is the last opened of its name.
  const auto last = std::find(open_stages_.rbegin(), open_stages_.rend(), name);
  if (last != open_stages_.rend()) open_stages_.erase(std::next(last).base());
}

Stage::Stage(Context& context, std::string name)
    : context_(context), name_(std::move(name)), start_(std::chrono::steady_clock::now()) {
  context_.enter(name_);
}

Stage::~Stage() {
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
  context_.leave(name_, elapsed.count());
}

}  // namespace turgor
