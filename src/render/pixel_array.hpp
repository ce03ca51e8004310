// A value for every pixel.
#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>

#include "turgor/core/parallel.hpp"

namespace turgor::render_detail {

/// Like a vector of fixed size, but first touched by all threads: the pages of a picture's buffers take
/// longer to come from the system than many a filter takes to run.
template <class T>
class PixelArray {
  static_assert(std::is_trivially_destructible_v<T>);

 public:
  PixelArray() = default;
  explicit PixelArray(std::size_t size) : data_(std::allocator<T>().allocate(size)), size_(size) {
    parallel_for(size, 1 << 14, [this](std::size_t begin, std::size_t end) {
      std::uninitialized_value_construct(data_ + begin, data_ + end);
    });
  }
  PixelArray(PixelArray&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}
  PixelArray& operator=(PixelArray&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~PixelArray() {
    if (data_) std::allocator<T>().deallocate(data_, size_);
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }

 private:
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace turgor::render_detail
