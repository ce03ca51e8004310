#include "turgor/core/parallel.hpp"

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

#include <memory>

namespace turgor {
namespace {

// TBB's own limit is process-wide, so ours is too.
std::unique_ptr<tbb::global_control> control;

}  // namespace

int thread_count() {
  return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

void set_thread_count(int count) {
  control.reset();
  if (count > 0) {
    control = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                    static_cast<std::size_t>(count));
  }
}

void detail::parallel_chunks(std::size_t chunks, const std::function<void(std::size_t)>& body) {
  // Workers keep the floating-point mode of whoever woke them first, and Embree flushes denormals: ours is
  // handed on with every loop, or the bits would depend on which thread does the work.
  tbb::task_group_context context(tbb::task_group_context::bound, tbb::task_group_context::default_traits |
                                                                      tbb::task_group_context::fp_settings);
  tbb::parallel_for(
      std::size_t{0}, chunks, [&](std::size_t c) { body(c); }, context);
}

}  // namespace turgor
