#include "turgor/geometry/bulk_array.hpp"

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace turgor::detail {
namespace {

constexpr std::size_t kPage = std::size_t{2} << 20;

constexpr bool is_large(std::size_t bytes) {
  return bytes >= 2 * kPage;
}

}  // namespace

void* bulk_allocate(std::size_t bytes) {
  if (!is_large(bytes)) return ::operator new(bytes);
  void* const memory = ::operator new (bytes, std::align_val_t{kPage});
#ifdef __linux__
  // A wish: without it all works alike. The last, partial page stays in small ones.
  (void)::madvise(memory, bytes / kPage * kPage, MADV_HUGEPAGE);
#endif
  return memory;
}

void bulk_free(void* memory, std::size_t bytes) noexcept {
  if (is_large(bytes)) {
    ::operator delete (memory, std::align_val_t{kPage});
  } else {
    ::operator delete(memory);
  }
}

}  // namespace turgor::detail
