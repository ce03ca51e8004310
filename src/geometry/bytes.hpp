// Assembling binary files in memory. Internal to the module.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <type_traits>
#include <vector>

namespace turgor::detail {

static_assert(std::endian::native == std::endian::little,
              "files are written in the machine's order of bytes");

class ByteWriter {
 public:
  explicit ByteWriter(std::size_t expected = 0) { bytes_.reserve(expected); }

  template <class T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    append(&value, sizeof value);
  }
  template <class T>
  void put_all(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    append(values.data(), values.size() * sizeof(T));
  }
  void text(std::string_view words) { append(words.data(), words.size()); }
  /// Fills up to a multiple of `alignment`.
  void pad(std::size_t alignment, char fill) {
    while (bytes_.size() % alignment != 0) bytes_.push_back(static_cast<std::byte>(fill));
  }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }
  [[nodiscard]] const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  void append(const void* from, std::size_t count) {
    if (count == 0) return;
    const auto* first = static_cast<const std::byte*>(from);
    bytes_.insert(bytes_.end(), first, first + count);
  }
  std::vector<std::byte> bytes_;
};

}  // namespace turgor::detail
