// JPEG as CT scanners write it (ITU-T T.81): one component, Huffman coded; sequential DCT of 8 or 12 bits
// (annexes F, A.3) and lossless with prediction (annex H). Written here because Debian has no library for the
// lossless process that survives damaged streams.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "imaging/scan/dicom_codecs.hpp"

namespace turgor::scan_io {
namespace {

/// Canonical Huffman code (annex C) with the decoder's tables (F.2.2.3).
class HuffmanTable {
 public:
  /// `counts`: codes of each length 1..16. False where they are not a prefix code.
  bool build(Bytes counts, Bytes values) {
    std::int32_t code = 0, index = 0;
    for (std::size_t length = 1; length <= 16; ++length) {
      const auto count = static_cast<std::int32_t>(counts[length - 1]);
      first_code_[length] = code;
      first_index_[length] = index;
      code += count;
      index += count;
      if (code > std::int32_t{1} << length) return false;
      end_code_[length] = code;
      code <<= 1;
    }
    std::transform(values.begin(), values.end(), values_.begin(),
                   [](std::byte b) { return std::uint8_t(b); });
    usable_ = true;
    return true;
  }
  [[nodiscard]] bool usable() const { return usable_; }

  /// The value of the next code, or -1.
  template <class Bits>
  int decode(Bits& bits) const {
    std::int32_t code = 0;
    for (std::size_t length = 1; length <= 16; ++length) {
      code = code << 1 | bits.next();
      if (code < end_code_[length]) {
        return values_[static_cast<std::size_t>(first_index_[length] + code - first_code_[length])];
      }
    }
    return -1;
  }

 private:
  std::array<std::int32_t, 17> first_code_{}, end_code_{}, first_index_{};
  std::array<std::uint8_t, 256> values_{};
  bool usable_ = false;
};

/// Entropy-coded bits: stuffed zeros are dropped, and a marker ends them.
class BitReader {
 public:
  explicit BitReader(Bytes bytes, std::size_t at) : bytes_(bytes), at_(at) {}

  int next() {
    if (left_ == 0) refill();
    --left_;
    return buffer_ >> left_ & 1;
  }
  int receive(int count) {
    int value = 0;
    for (; count > 0; --count) value = value << 1 | next();
    return value;
  }
  /// True once bits were asked for that the stream does not have.
  [[nodiscard]] bool exhausted() const { return exhausted_; }

  /// Steps over a restart marker. False where there is none.
  bool restart() {
    left_ = 0;
    while (at_ + 1 < bytes_.size() && bytes_[at_] == std::byte{0xFF} && bytes_[at_ + 1] == std::byte{0xFF})
      ++at_;
    if (at_ + 1 >= bytes_.size() || bytes_[at_] != std::byte{0xFF} ||
        (bytes_[at_ + 1] & std::byte{0xF8}) != std::byte{0xD0}) {
      return false;
    }
    at_ += 2;
    return true;
  }

 private:
  void refill() {
    left_ = 8;
    buffer_ = 0;
    if (at_ >= bytes_.size()) {
      exhausted_ = true;
      return;
    }
    buffer_ = static_cast<int>(bytes_[at_]);
    if (buffer_ == 0xFF) {
      if (at_ + 1 >= bytes_.size() || bytes_[at_ + 1] != std::byte{0}) {
        exhausted_ = true;
        return;
      }
      ++at_;
    }
    ++at_;
  }

  Bytes bytes_;
  std::size_t at_;
  int buffer_ = 0, left_ = 0;
  bool exhausted_ = false;
};

/// The signed number that `count` bits stand for (F.2.2.1, EXTEND).
int extend(int value, int count) {
  return value < 1 << (count - 1) ? value - (1 << count) + 1 : value;
}

enum class Process { none, dct, lossless };

/// What the segments before the scan define.
struct Tables {
  Process process = Process::none;
  int precision = 0, rows = 0, columns = 0;
  std::size_t quantization_index = 0;
  std::array<std::array<int, 64>, 4> quantization{};
  std::array<HuffmanTable, 4> dc, ac;
  int restart_interval = 0;
  // Of the scan:
  std::size_t dc_index = 0, ac_index = 0;
  int predictor = 0, point_transform = 0;
  std::size_t data = 0;  // where the entropy-coded bits start
};

/// Zigzag position to place in the block (figure A.6).
constexpr std::array<std::uint8_t, 64> kZigzag{
    0,  1,  8,  16, 9,  2,  3,  10, 17, 24, 32, 25, 18, 11, 4,  5,  12, 19, 26, 33, 40, 48,
    41, 34, 27, 20, 13, 6,  7,  14, 21, 28, 35, 42, 49, 56, 57, 50, 43, 36, 29, 22, 15, 23,
    30, 37, 44, 51, 58, 59, 52, 45, 38, 31, 39, 46, 53, 60, 61, 54, 47, 55, 62, 63};

/// Reads marker segments up to the scan.
class SegmentReader {
 public:
  explicit SegmentReader(Bytes bytes) : b_(bytes) {}

  std::optional<Tables> read() {
    if (b_.size() < 4 || u16(0) != 0xFFD8) return std::nullopt;
    std::size_t at = 2;
    while (at + 4 <= b_.size() && b_[at] == std::byte{0xFF}) {
      const int marker = u8(at + 1);
      if (marker == 0xFF) {  // fill byte
        ++at;
        continue;
      }
      const auto length = static_cast<std::size_t>(u16(at + 2));
      if (length < 2 || length > b_.size() - at - 2) return std::nullopt;
      if (!segment(marker, at + 4, at + 2 + length)) return std::nullopt;
      at += 2 + length;
      if (marker == 0xDA) {
        tables_.data = at;
        return tables_;
      }
    }
    return std::nullopt;
  }

 private:
  [[nodiscard]] int u8(std::size_t at) const { return static_cast<int>(b_[at]); }
  [[nodiscard]] int u16(std::size_t at) const { return u8(at) << 8 | u8(at + 1); }

  bool segment(int marker, std::size_t at, std::size_t end) {
    switch (marker) {
      case 0xC0:
      case 0xC1:
        return frame(Process::dct, at, end);
      case 0xC3:
        return frame(Process::lossless, at, end);
      case 0xC4:
        return huffman(at, end);
      case 0xDB:
        return quantization(at, end);
      case 0xDA:
        return scan(at, end);
      case 0xDD:
        if (end - at != 2) return false;
        tables_.restart_interval = u16(at);
        return true;
      default:
        // Application data and comments pass; other processes (progressive, arithmetic) are not CT's.
        return (marker >= 0xE0 && marker <= 0xEF) || marker == 0xFE;
    }
  }

  bool frame(Process process, std::size_t at, std::size_t end) {
    if (end - at != 9 || u8(at + 5) != 1 || tables_.process != Process::none) return false;
    tables_.process = process;
    tables_.precision = u8(at);
    tables_.rows = u16(at + 1);
    tables_.columns = u16(at + 3);
    tables_.quantization_index = static_cast<std::size_t>(u8(at + 8) & 3);
    // The standard knows 8 and 12 bits for the cosine transform; GDCM writes 16 as well.
    return tables_.precision >= 2 && tables_.precision <= 16;
  }

  bool huffman(std::size_t at, std::size_t end) {
    while (at < end) {
      if (end - at < 17) return false;
      const int kind = u8(at);
      const Bytes counts = b_.subspan(at + 1, 16);
      std::size_t total = 0;
      for (const std::byte c : counts) total += static_cast<std::size_t>(c);
      at += 17;
      if (total > 256 || total > end - at || kind > 0x13 || (kind & 0x0F) > 3) return false;
      auto& table = (kind >> 4 == 0 ? tables_.dc : tables_.ac)[static_cast<std::size_t>(kind & 3)];
      if (!table.build(counts, b_.subspan(at, total))) return false;
      at += total;
    }
    return true;
  }

  bool quantization(std::size_t at, std::size_t end) {
    while (at < end) {
      const int kind = u8(at++);
      const std::size_t width = kind >> 4 == 0 ? 1 : 2;
      if (end - at < 64 * width || kind >> 4 > 1 || (kind & 0x0F) > 3) return false;
      for (std::size_t n = 0; n < 64; ++n, at += width) {
        tables_.quantization[static_cast<std::size_t>(kind & 3)][kZigzag[n]] = width == 1 ? u8(at) : u16(at);
      }
    }
    return true;
  }

  bool scan(std::size_t at, std::size_t end) {
    if (end - at != 6 || u8(at) != 1 || tables_.process == Process::none) return false;
    tables_.dc_index = static_cast<std::size_t>(u8(at + 2) >> 4 & 3);
    tables_.ac_index = static_cast<std::size_t>(u8(at + 2) & 3);
    tables_.predictor = u8(at + 3);
    tables_.point_transform = u8(at + 5) & 0x0F;
    if (!tables_.dc[tables_.dc_index].usable()) return false;
    if (tables_.process == Process::dct) return tables_.ac[tables_.ac_index].usable();
    return tables_.predictor >= 1 && tables_.predictor <= 7 && tables_.point_transform < tables_.precision;
  }

  Bytes b_;
  Tables tables_;
};

/// Prediction from the left, upper and upper left neighbour (table H.1).
int predict(int selection, int left, int above, int corner) {
  switch (selection) {
    case 1:
      return left;
    case 2:
      return above;
    case 3:
      return corner;
    case 4:
      return left + above - corner;
    case 5:
      return left + ((above - corner) >> 1);
    case 6:
      return above + ((left - corner) >> 1);
    default:
      return (left + above) >> 1;
  }
}

std::optional<Samples> decode_lossless(Bytes coded, const Tables& t) {
  const auto columns = static_cast<std::size_t>(t.columns), rows = static_cast<std::size_t>(t.rows);
  const auto interval = static_cast<std::size_t>(t.restart_interval);
  if (interval % columns != 0) return std::nullopt;  // H.1.1: whole rows
  BitReader bits(coded, t.data);
  const HuffmanTable& table = t.dc[t.dc_index];
  Samples out(rows * columns);
  std::size_t first_row = 0;  // of the restart interval, whose prediction starts anew
  for (std::size_t y = 0; y < rows; ++y) {
    if (interval > 0 && y > 0 && y * columns % interval == 0) {
      if (!bits.restart()) return std::nullopt;
      first_row = y;
    }
    std::uint16_t* row = out.data() + y * columns;
    const std::uint16_t* up = y > first_row ? row - columns : nullptr;
    for (std::size_t x = 0; x < columns; ++x) {
      const int category = table.decode(bits);
      if (category < 0 || category > 16) return std::nullopt;
      const int difference = category == 0    ? 0
                             : category == 16 ? 32768
                                              : extend(bits.receive(category), category);
      int prediction = 0;
      if (up == nullptr) {
        prediction = x > 0 ? row[x - 1] : 1 << (t.precision - t.point_transform - 1);
      } else {
        prediction = x > 0 ? predict(t.predictor, row[x - 1], up[x], up[x - 1]) : up[0];
      }
      row[x] = static_cast<std::uint16_t>(prediction + difference);
    }
    if (bits.exhausted()) return std::nullopt;
  }
  for (std::uint16_t& v : out) v = static_cast<std::uint16_t>(v << t.point_transform);
  return out;
}

/// Inverse cosine transform by rows and columns (A.3.3).
class InverseDct {
 public:
  InverseDct() {
    for (std::size_t x = 0; x < 8; ++x) {
      for (std::size_t u = 0; u < 8; ++u) {
        const double angle =
            (2.0 * static_cast<double>(x) + 1) * static_cast<double>(u) * std::numbers::pi / 16;
        basis_[x][u] = 0.5 * (u == 0 ? std::numbers::sqrt2 / 2 : 1.0) * std::cos(angle);
      }
    }
  }
  void transform(std::array<double, 64>& block) const {
    std::array<double, 64> half{};
    for (std::size_t v = 0; v < 8; ++v) {
      for (std::size_t x = 0; x < 8; ++x) {
        for (std::size_t u = 0; u < 8; ++u) half[v * 8 + x] += basis_[x][u] * block[v * 8 + u];
      }
    }
    block = {};
    for (std::size_t y = 0; y < 8; ++y) {
      for (std::size_t v = 0; v < 8; ++v) {
        for (std::size_t x = 0; x < 8; ++x) block[y * 8 + x] += basis_[y][v] * half[v * 8 + x];
      }
    }
  }

 private:
  std::array<std::array<double, 8>, 8> basis_{};
};

/// Dequantized coefficients of the next block; false where the stream is damaged.
bool read_block(BitReader& bits, const Tables& t, int& dc, std::array<double, 64>& block) {
  const auto& quantization = t.quantization[t.quantization_index];
  const int category = t.dc[t.dc_index].decode(bits);
  if (category < 0 || category > 15) return false;
  if (category > 0) dc += extend(bits.receive(category), category);
  if (std::abs(dc) > 1 << 20) return false;
  block = {};
  block[0] = static_cast<double>(dc) * quantization[0];
  for (std::size_t n = 1; n < 64; ++n) {
    const int code = t.ac[t.ac_index].decode(bits);
    if (code < 0) return false;
    const int size = code & 0x0F;
    if (size == 0 && code != 0xF0) break;  // end of block
    n += static_cast<std::size_t>(code >> 4);
    if (n > 63) return false;
    if (size > 0)
      block[kZigzag[n]] = static_cast<double>(extend(bits.receive(size), size)) * quantization[kZigzag[n]];
  }
  return !bits.exhausted();
}

std::optional<Samples> decode_dct(Bytes coded, const Tables& t) {
  static const InverseDct inverse;
  const auto columns = static_cast<std::size_t>(t.columns), rows = static_cast<std::size_t>(t.rows);
  BitReader bits(coded, t.data);
  Samples out(rows * columns);
  const double middle = 1 << (t.precision - 1), highest = (1 << t.precision) - 1;
  std::array<double, 64> block{};
  int dc = 0, done = 0;
  for (std::size_t top = 0; top < rows; top += 8) {
    for (std::size_t left = 0; left < columns; left += 8, ++done) {
      if (t.restart_interval > 0 && done > 0 && done % t.restart_interval == 0) {
        if (!bits.restart()) return std::nullopt;
        dc = 0;
      }
      if (!read_block(bits, t, dc, block)) return std::nullopt;
      inverse.transform(block);
      for (std::size_t y = 0; y < std::min<std::size_t>(8, rows - top); ++y) {
        for (std::size_t x = 0; x < std::min<std::size_t>(8, columns - left); ++x) {
          const double value = std::floor(block[y * 8 + x] + middle + 0.5);
          out[(top + y) * columns + left + x] = static_cast<std::uint16_t>(std::clamp(value, 0.0, highest));
        }
      }
    }
  }
  return out;
}

}  // namespace

std::optional<Samples> decode_jpeg(Bytes coded, const PixelLayout& layout) {
  const auto tables = SegmentReader(coded).read();
  if (!tables || tables->rows != layout.rows || tables->columns != layout.columns ||
      tables->precision > layout.bits_allocated) {
    return std::nullopt;
  }
  return tables->process == Process::dct ? decode_dct(coded, *tables) : decode_lossless(coded, *tables);
}

}  // namespace turgor::scan_io
