// Remeshing on a thread of its own.
#include <atomic>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "turgor/geometry/solid_remesh.hpp"

namespace turgor {

struct BackgroundRemesh::Work {
  RemeshSnapshot snapshot;
  RemeshOptions options;
  std::atomic<bool> cancelled{false}, done{false};
  std::optional<Result<RemeshedSolid>> result;  ///< read once `done` is set
  std::thread thread;

  ~Work() {
    cancelled = true;
    if (thread.joinable()) thread.join();
  }
  void run() {
    const Context context({}, {}, [this] { return cancelled.load(); });
    result.emplace(remesh_solid(snapshot, options, context));
    done = true;
  }
};

BackgroundRemesh::BackgroundRemesh() = default;
BackgroundRemesh::~BackgroundRemesh() = default;
BackgroundRemesh::BackgroundRemesh(BackgroundRemesh&&) noexcept = default;
BackgroundRemesh& BackgroundRemesh::operator=(BackgroundRemesh&&) noexcept = default;

Result<void> BackgroundRemesh::start(RemeshSnapshot snapshot, const RemeshOptions& options) {
  cancel();
  auto work = std::make_unique<Work>();
  work->snapshot = std::move(snapshot), work->options = options;
  try {
    work->thread = std::thread(&Work::run, work.get());
  } catch (const std::system_error& error) {
    return Error{ErrorKind::system, "no thread could be started for remeshing", error.what(),
                 "Close other programs"};
  }
  work_ = std::move(work);
  return {};
}

bool BackgroundRemesh::started() const {
  return work_ != nullptr;
}
bool BackgroundRemesh::ready() const {
  return work_ != nullptr && work_->done;
}

Result<RemeshedSolid> BackgroundRemesh::take() {
  if (work_ == nullptr) return Error{ErrorKind::internal, "no remeshing was started", "", ""};
  work_->thread.join();
  Result<RemeshedSolid> result = *std::move(work_->result);
  work_.reset();
  return result;
}

void BackgroundRemesh::cancel() {
  work_.reset();
}

}  // namespace turgor
