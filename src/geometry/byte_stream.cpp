#include "geometry/byte_stream.hpp"

#include <zlib.h>

#include <array>
#include <cctype>
#include <cstdint>

namespace turgor::detail {
namespace {

/// Value of a character of base64; -1 for others.
int sextet(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+') return 62;
  return c == '/' ? 63 : -1;
}

}  // namespace

bool ByteStream::decode_group() {
  std::array<char, 4> group{};
  for (char& c : group) {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) ++at_;
    if (at_ == text_.size()) return false;
    c = text_[at_++];
  }
  const int padding = group[3] != '=' ? 0 : group[2] != '=' ? 1 : 2;
  std::uint32_t bits = 0;
  for (std::size_t n = 0; n < 4; ++n) {
    const int value = n + static_cast<std::size_t>(padding) < 4 ? sextet(group[n]) : 0;
    if (value < 0) return false;
    bits = bits << 6 | static_cast<std::uint32_t>(value);
  }
  for (int n = 0; n < 3 - padding; ++n) held_.push_back(static_cast<std::byte>(bits >> (16 - 8 * n) & 0xFF));
  return true;
}

std::optional<std::vector<std::byte>> ByteStream::take(std::size_t count) {
  if (count > left()) return std::nullopt;
  if (!coded_) {
    const auto* first = reinterpret_cast<const std::byte*>(text_.data()) + at_;
    at_ += count;
    return std::vector<std::byte>(first, first + count);
  }
  while (held_.size() < count) {
    if (!decode_group()) return std::nullopt;
  }
  std::vector<std::byte> out(held_.begin(), held_.begin() + static_cast<std::ptrdiff_t>(count));
  held_.erase(held_.begin(), held_.begin() + static_cast<std::ptrdiff_t>(count));
  return out;
}

std::optional<std::vector<std::byte>> inflate_exactly(std::span<const std::byte> compressed,
                                                      std::size_t size) {
  if (size > compressed.size() * kMostInflated) return std::nullopt;
  std::vector<std::byte> out(size);
  auto length = static_cast<uLongf>(size);
  const int code =
      uncompress(reinterpret_cast<Bytef*>(out.data()), &length,
                 reinterpret_cast<const Bytef*>(compressed.data()), static_cast<uLong>(compressed.size()));
  if (code != Z_OK || length != size) return std::nullopt;
  return out;
}

}  // namespace turgor::detail
