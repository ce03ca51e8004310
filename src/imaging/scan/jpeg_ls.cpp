// JPEG-LS (ITU-T T.87) of one component, lossless and near-lossless. Written here because CharLS 2.4 can spin
// for half a minute on a damaged stream of a hundred bytes. Names and tables are those of annex A.
#include <algorithm>
#include <array>
#include <cstdlib>

#include "imaging/scan/dicom_codecs.hpp"

namespace turgor::scan_io {
namespace {

/// Bits of a scan: after a byte of ones the next has seven bits, and a marker ends them (A.1).
class ScanBits {
 public:
  ScanBits(Bytes bytes, std::size_t at) : bytes_(bytes), at_(at) {}

  int next() {
    if (left_ == 0) refill();
    --left_;
    return buffer_ >> left_ & 1;
  }
  std::int64_t receive(int count) {
    std::int64_t value = 0;
    for (; count > 0; --count) value = value << 1 | next();
    return value;
  }
  /// True once bits were asked for that the stream does not have.
  [[nodiscard]] bool exhausted() const { return exhausted_; }

 private:
  void refill() {
    const bool stuffed = buffer_ == 0xFF;
    left_ = stuffed ? 7 : 8;
    buffer_ = 0;
    if (at_ >= bytes_.size() || (stuffed && (bytes_[at_] & std::byte{0x80}) != std::byte{})) {
      exhausted_ = true;
      return;
    }
    buffer_ = static_cast<int>(bytes_[at_++]);
  }

  Bytes bytes_;
  std::size_t at_;
  int buffer_ = 0, left_ = 0;
  bool exhausted_ = false;
};

struct Parameters {
  int precision = 0, rows = 0, columns = 0;
  int maxval = 0, t1 = 0, t2 = 0, t3 = 0, reset = 0;  // zero: the default
  int near = 0;
  std::size_t data = 0;  // where the scan's bits start
};

/// Reads the marker segments up to the scan.
class HeaderReader {
 public:
  explicit HeaderReader(Bytes bytes) : b_(bytes) {}

  std::optional<Parameters> read() {
    if (b_.size() < 4 || u16(0) != 0xFFD8) return std::nullopt;
    std::size_t at = 2;
    while (at + 4 <= b_.size() && u8(at) == 0xFF) {
      const int marker = u8(at + 1);
      const auto length = static_cast<std::size_t>(u16(at + 2));
      if (length < 2 || length > b_.size() - at - 2 || !segment(marker, at + 4, length - 2))
        return std::nullopt;
      at += 2 + length;
      if (marker != 0xDA) continue;
      p_.data = at;
      return complete() ? std::optional(p_) : std::nullopt;
    }
    return std::nullopt;
  }

 private:
  [[nodiscard]] int u8(std::size_t at) const { return static_cast<int>(b_[at]); }
  [[nodiscard]] int u16(std::size_t at) const { return u8(at) << 8 | u8(at + 1); }

  bool segment(int marker, std::size_t at, std::size_t size) {
    if (marker == 0xF7) {  // frame
      if (size != 9 || u8(at + 5) != 1) return false;
      p_.precision = u8(at), p_.rows = u16(at + 1), p_.columns = u16(at + 3);
      return p_.precision >= 2 && p_.precision <= 16;
    }
    if (marker == 0xF8) {  // preset parameters; mapping tables are not CT's
      if (size != 11 || u8(at) != 1) return false;
      p_.maxval = u16(at + 1), p_.t1 = u16(at + 3), p_.t2 = u16(at + 5), p_.t3 = u16(at + 7),
      p_.reset = u16(at + 9);
      return true;
    }
    if (marker == 0xDA) {  // scan of one component without mapping table
      if (size != 6 || u8(at) != 1 || u8(at + 2) != 0) return false;
      p_.near = u8(at + 3);
      return true;
    }
    return (marker >= 0xE0 && marker <= 0xEF) || marker == 0xFE;
  }

  /// Defaults of C.2.4.1.1, and the ranges that the standard sets.
  bool complete() {
    if (p_.precision == 0) return false;
    const int highest = (1 << p_.precision) - 1;
    if (p_.maxval == 0) p_.maxval = highest;
    if (p_.maxval > highest || p_.near > std::min(255, p_.maxval / 2)) return false;
    const auto clamp = [&](int i, int j) { return i > p_.maxval || i < j ? j : i; };
    const int near = p_.near;
    std::array<int, 3> defaults{};
    if (p_.maxval >= 128) {
      const int factor = (std::min(p_.maxval, 4095) + 128) / 256;
      defaults = {factor + 2 + 3 * near, factor * 4 + 3 + 5 * near, factor * 17 + 4 + 7 * near};
    } else {
      const int factor = 256 / (p_.maxval + 1);
      defaults = {std::max(2, 3 / factor + 3 * near), std::max(3, 7 / factor + 5 * near),
                  std::max(4, 21 / factor + 7 * near)};
    }
    if (p_.t1 == 0) p_.t1 = clamp(defaults[0], near + 1);
    if (p_.t2 == 0) p_.t2 = clamp(defaults[1], p_.t1);
    if (p_.t3 == 0) p_.t3 = clamp(defaults[2], p_.t2);
    if (p_.reset == 0) p_.reset = 64;
    return p_.t1 > near && p_.t1 <= p_.t2 && p_.t2 <= p_.t3 && p_.t3 <= p_.maxval && p_.reset >= 3 &&
           p_.reset <= std::max(255, p_.maxval);
  }

  Bytes b_;
  Parameters p_;
};

constexpr std::array<int, 32> kJ{0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2,  2,  3,  3,  3,  3,
                                 4, 4, 5, 5, 6, 6, 7, 7, 8, 9, 10, 11, 12, 13, 14, 15};

int bits_for(int count) {  // ceil(log2(count))
  int bits = 0;
  while ((1 << bits) < count) ++bits;
  return bits;
}

class ScanDecoder {
 public:
  ScanDecoder(Bytes coded, const Parameters& p) : p_(p), bits_(coded, p.data) {
    step_ = 2 * p.near + 1;
    range_ = (p.maxval + 2 * p.near) / step_ + 1;
    qbpp_ = bits_for(range_);
    const int bpp = std::max(2, bits_for(p.maxval + 1));
    limit_ = 2 * (bpp + std::max(8, bpp));
    for (Context& c : contexts_) c.a = std::max(2, (range_ + 32) / 64);
  }

  std::optional<Samples> decode() {
    const auto columns = static_cast<std::size_t>(p_.columns), rows = static_cast<std::size_t>(p_.rows);
    Samples out(columns * rows);
    // One sample of margin on either side of each line (A.2.1).
    std::vector<int> above(columns + 2, 0), line(columns + 2, 0);
    for (std::size_t y = 0; y < rows; ++y) {
      line[0] = above[1];
      above[columns + 1] = above[columns];
      decode_line(above, line);
      if (bits_.exhausted()) return std::nullopt;
      std::transform(line.begin() + 1, line.end() - 1, out.begin() + static_cast<std::ptrdiff_t>(y * columns),
                     [](int v) { return static_cast<std::uint16_t>(v); });
      std::swap(above, line);
    }
    return out;
  }

 private:
  struct Context {
    std::int64_t a = 0, b = 0, c = 0, n = 1;
  };

  void decode_line(const std::vector<int>& above, std::vector<int>& line) {
    const auto columns = static_cast<std::size_t>(p_.columns);
    for (std::size_t x = 1; x <= columns && !bits_.exhausted();) {
      const int ra = line[x - 1], rb = above[x], rc = above[x - 1], rd = above[x + 1];
      const int q1 = quantize(rd - rb), q2 = quantize(rb - rc), q3 = quantize(rc - ra);
      if (q1 == 0 && q2 == 0 && q3 == 0) {
        x = decode_run(above, line, x);
      } else {
        line[x++] = decode_regular(81 * q1 + 9 * q2 + q3, predict(ra, rb, rc));
      }
    }
  }

  [[nodiscard]] int quantize(int d) const {
    const int size = std::abs(d);
    const int q = size <= p_.near ? 0 : size < p_.t1 ? 1 : size < p_.t2 ? 2 : size < p_.t3 ? 3 : 4;
    return d < 0 ? -q : q;
  }

  static int predict(int ra, int rb, int rc) {
    if (rc >= std::max(ra, rb)) return std::min(ra, rb);
    if (rc <= std::min(ra, rb)) return std::max(ra, rb);
    return ra + rb - rc;
  }

  static int golomb_parameter(std::int64_t n, std::int64_t a) {
    int k = 0;
    while (n << k < a && k < 24) ++k;
    return k;
  }

  /// Limited-length Golomb code (A.5.3).
  std::int64_t golomb(int k, int limit) {
    int zeros = 0;
    const int most = limit - qbpp_ - 1;
    while (zeros < most && bits_.next() == 0) ++zeros;
    if (zeros < most) return (std::int64_t{zeros} << k) + bits_.receive(k);
    // All zeros of the escape code have been read, but for the one that ends them.
    while (!bits_.exhausted() && zeros < limit && bits_.next() == 0) ++zeros;
    return bits_.receive(qbpp_) + 1;
  }

  /// The sample from prediction and error, brought back into range (A.4.4, A.5.4).
  [[nodiscard]] int reconstruct(int prediction, std::int64_t error) const {
    std::int64_t value = prediction + error * step_;
    const std::int64_t span = std::int64_t{range_} * step_;
    if (value < -p_.near) {
      value += span;
    } else if (value > p_.maxval + p_.near) {
      value -= span;
    }
    return static_cast<int>(std::clamp<std::int64_t>(value, 0, p_.maxval));
  }

  int decode_regular(int q, int prediction) {
    const int sign = q < 0 ? -1 : 1;
    q *= sign;
    Context& c = contexts_[static_cast<std::size_t>(q)];
    prediction = std::clamp(prediction + sign * static_cast<int>(c.c), 0, p_.maxval);
    const int k = golomb_parameter(c.n, c.a);
    const std::int64_t mapped = golomb(k, limit_);
    std::int64_t error = (mapped & 1) != 0 ? -(mapped + 1) / 2 : mapped / 2;
    if (p_.near == 0 && k == 0 && 2 * c.b <= -c.n) error = -error - 1;
    update(c, error);
    return reconstruct(prediction, sign * error);
  }

  void update(Context& c, std::int64_t error) const {
    c.b += error * step_;
    c.a += std::abs(error);
    if (c.n == p_.reset) {
      c.a >>= 1;
      c.b = c.b >= 0 ? c.b >> 1 : -((1 - c.b) >> 1);
      c.n >>= 1;
    }
    ++c.n;
    if (c.b <= -c.n) {
      c.b = std::max(c.b + c.n, 1 - c.n);
      c.c = std::max<std::int64_t>(c.c - 1, -128);
    } else if (c.b > 0) {
      c.b = std::min<std::int64_t>(c.b - c.n, 0);
      c.c = std::min<std::int64_t>(c.c + 1, 127);
    }
  }

  /// Fills the run from `x` and decodes the sample that breaks it (A.7). Returns the next place.
  std::size_t decode_run(const std::vector<int>& above, std::vector<int>& line, std::size_t x) {
    const std::size_t end = line.size() - 1;
    const int ra = line[x - 1];
    while (x < end) {
      if (bits_.next() == 0) {
        const auto rest = static_cast<std::size_t>(bits_.receive(kJ[run_index_]));
        for (std::size_t n = 0; n < rest && x < end; ++n) line[x++] = ra;
        if (x == end) return x;
        line[x] = decode_interruption(ra, above[x]);
        if (run_index_ > 0) --run_index_;
        return x + 1;
      }
      const std::size_t length = std::size_t{1} << kJ[run_index_];
      const std::size_t filled = std::min(length, end - x);
      std::fill_n(line.begin() + static_cast<std::ptrdiff_t>(x), filled, ra);
      x += filled;
      if (filled == length && run_index_ < 31) ++run_index_;
      if (bits_.exhausted()) return end;
    }
    return x;
  }

  int decode_interruption(int ra, int rb) {
    const int type = std::abs(ra - rb) <= p_.near ? 1 : 0;
    Context& c = contexts_[type == 0 ? 365 : 366];
    std::int64_t& negative = c.b;  // Nn: how often the error was negative
    const int k = golomb_parameter(c.n, type == 0 ? c.a : c.a + (c.n >> 1));
    const std::int64_t mapped = golomb(k, limit_ - kJ[run_index_] - 1);
    const std::int64_t doubled = mapped + type;
    const bool odd = (doubled & 1) != 0;
    const std::int64_t size = (doubled + (odd ? 1 : 0)) / 2;
    const std::int64_t error = (k != 0 || 2 * negative >= c.n) == odd ? -size : size;
    if (error < 0) ++negative;
    c.a += (mapped + 1 - type) >> 1;
    if (c.n == p_.reset) c.a >>= 1, negative >>= 1, c.n >>= 1;
    ++c.n;
    const bool mirrored = type == 0 && ra > rb;
    return reconstruct(type == 1 ? ra : rb, mirrored ? -error : error);
  }

  const Parameters& p_;
  ScanBits bits_;
  int step_ = 1, range_ = 0, qbpp_ = 0, limit_ = 0;
  std::array<Context, 367> contexts_{};
  std::size_t run_index_ = 0;
};

}  // namespace

std::optional<Samples> decode_jpeg_ls(Bytes coded, const PixelLayout& layout) {
  const auto parameters = HeaderReader(coded).read();
  if (!parameters || parameters->rows != layout.rows || parameters->columns != layout.columns ||
      parameters->precision > layout.bits_allocated) {
    return std::nullopt;
  }
  return ScanDecoder(coded, *parameters).decode();
}

}  // namespace turgor::scan_io
