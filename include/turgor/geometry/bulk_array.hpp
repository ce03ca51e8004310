// Arrays of a hundred megabytes that are written once, in parallel: never filled with zeros first, and in
// large pages where the system has them, as the pages cost more than the numbers in them.
#pragma once

#include <cstddef>
#include <new>
#include <utility>
#include <vector>

namespace turgor {

namespace detail {
void* bulk_allocate(std::size_t bytes);
void bulk_free(void* memory, std::size_t bytes) noexcept;
}  // namespace detail

template <class T>
struct BulkAllocator {
  using value_type = T;
  BulkAllocator() = default;
  template <class U>
  BulkAllocator(const BulkAllocator<U>&) noexcept {}
  T* allocate(std::size_t n) { return static_cast<T*>(detail::bulk_allocate(n * sizeof(T))); }
  void deallocate(T* memory, std::size_t n) noexcept { detail::bulk_free(memory, n * sizeof(T)); }
  /// resize() leaves new elements of plain types unset.
  template <class U>
  void construct(U* at) noexcept {
    ::new (static_cast<void*>(at)) U;
  }
  template <class U, class... A>
  void construct(U* at, A&&... a) {
    ::new (static_cast<void*>(at)) U(std::forward<A>(a)...);
  }
  bool operator==(const BulkAllocator&) const = default;
};

template <class T>
using BulkArray = std::vector<T, BulkAllocator<T>>;

}  // namespace turgor
