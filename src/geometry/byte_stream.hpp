// Bytes as files wrap them: base64 and zlib. Internal to the module.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace turgor::detail {

/// Bytes one after another, raw or out of base64 (RFC 4648; blanks are passed over, and what follows padding
/// goes on, as VTK joins a header and its data).
class ByteStream {
 public:
  static ByteStream raw(std::string_view bytes) { return {bytes, false}; }
  static ByteStream base64(std::string_view text) { return {text, true}; }

  /// The next `count` bytes; nothing where there are fewer, or a character is not of base64.
  std::optional<std::vector<std::byte>> take(std::size_t count);
  /// No more bytes than this are left.
  [[nodiscard]] std::size_t left() const { return text_.size() - at_ + held_.size(); }

 private:
  ByteStream(std::string_view text, bool coded) : text_(text), coded_(coded) {}
  /// Four characters of base64; false at the end or for others.
  bool decode_group();
  std::string_view text_;
  std::size_t at_ = 0;
  bool coded_;
  std::vector<std::byte> held_;  ///< decoded and not yet taken
};

/// Inflates a zlib stream of exactly `size` bytes; nothing where it is another.
std::optional<std::vector<std::byte>> inflate_exactly(std::span<const std::byte> compressed,
                                                      std::size_t size);
/// More than zlib can make of one byte.
constexpr std::size_t kMostInflated = 1040;

}  // namespace turgor::detail
