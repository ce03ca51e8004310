#include "imaging/scan/inflate.hpp"

#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <limits>

#include "turgor/core/parallel.hpp"

namespace turgor::scan_io {
namespace {

constexpr std::size_t kChunk = std::size_t{1} << 20;

class InflateStream {
 public:
  explicit InflateStream(Deflate kind) {
    ready_ = inflateInit2(&stream_, kind == Deflate::raw ? -15 : 15 + 32) == Z_OK;
  }
  InflateStream(const InflateStream&) = delete;
  InflateStream& operator=(const InflateStream&) = delete;
  ~InflateStream() { inflateEnd(&stream_); }
  [[nodiscard]] bool ready() const { return ready_; }
  z_stream& operator*() { return stream_; }

 private:
  z_stream stream_{};
  bool ready_;
};

unsigned step_size(std::size_t bytes) {
  return static_cast<unsigned>(std::min<std::size_t>(bytes, std::numeric_limits<unsigned>::max()));
}

}  // namespace

Inflated inflate_bytes(std::span<const std::byte> compressed, std::size_t max_bytes, Deflate kind,
                       const Context* context) {
  Inflated result;
  InflateStream stream(kind);
  z_stream& z = *stream;
  std::size_t used = 0, done = 0;
  int status = stream.ready() ? Z_OK : Z_MEM_ERROR;
  while (status == Z_OK && done < max_bytes && !(context != nullptr && context->cancelled())) {
    if (result.bytes.size() - done < kChunk / 16) {
      // Doubling keeps copies few; the limit keeps a lying header from asking for memory.
      result.bytes.resize(std::min(max_bytes, std::max(done + kChunk / 8, 2 * done)));
    }
    z.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(compressed.data() + used));
    z.avail_in = step_size(compressed.size() - used);
    z.next_out = reinterpret_cast<Bytef*>(result.bytes.data() + done);
    z.avail_out = step_size(std::min(result.bytes.size() - done, 16 * kChunk));
    const unsigned in_before = z.avail_in, out_before = z.avail_out;
    status = inflate(&z, Z_NO_FLUSH);
    used += in_before - z.avail_in;
    done += out_before - z.avail_out;
    // Further members may follow a finished gzip stream.
    if (status == Z_STREAM_END && kind != Deflate::raw && compressed.size() - used > 18 &&
        compressed[used] == std::byte{0x1F} && compressed[used + 1] == std::byte{0x8B}) {
      status = inflateReset(&z);
    }
  }
  result.bytes.resize(done);
  result.damaged = status != Z_STREAM_END && done < max_bytes;
  return result;
}

namespace {

/// One part of a longer deflate stream: it may refer to the 32 KiB before it and ends on a byte boundary.
std::vector<std::byte> deflate_part(std::span<const std::byte> all, std::size_t begin, std::size_t end,
                                    int level) {
  z_stream z{};
  if (deflateInit2(&z, level, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY) != Z_OK) return {};
  const std::size_t before = std::min<std::size_t>(begin, 32768);
  const auto pointer = [&](std::size_t at) {
    return reinterpret_cast<Bytef*>(const_cast<std::byte*>(all.data() + at));
  };
  if (before > 0) deflateSetDictionary(&z, pointer(begin - before), static_cast<uInt>(before));
  std::vector<std::byte> out(deflateBound(&z, static_cast<uLong>(end - begin)) + 64);
  z.next_in = pointer(begin);
  z.avail_in = static_cast<uInt>(end - begin);
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = static_cast<uInt>(out.size());
  deflate(&z, end == all.size() ? Z_FINISH : Z_SYNC_FLUSH);
  out.resize(out.size() - z.avail_out);
  deflateEnd(&z);
  return out;
}

void append_little32(std::vector<std::byte>& out, std::uint64_t value) {
  for (int i = 0; i < 4; ++i) out.push_back(static_cast<std::byte>(value >> (8 * i) & 0xFF));
}

}  // namespace

std::vector<std::byte> gzip_bytes(std::span<const std::byte> bytes, int level) {
  const std::size_t parts = std::max<std::size_t>(1, (bytes.size() + kChunk - 1) / kChunk);
  std::vector<std::vector<std::byte>> packed(parts);
  std::vector<uLong> sums(parts);
  parallel_for(parts, 1, [&](std::size_t part, std::size_t) {
    const std::size_t begin = part * kChunk, end = std::min(bytes.size(), begin + kChunk);
    packed[part] = deflate_part(bytes, begin, end, level);
    sums[part] = crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data() + begin), end - begin);
  });
  // Header of RFC 1952 without name and time, so that equal input gives equal files.
  std::vector<std::byte> out{std::byte{0x1F}, std::byte{0x8B}, std::byte{8}, {}, {}, {}, {}, {}, {},
                             std::byte{255}};
  uLong sum = crc32_z(0, nullptr, 0);
  for (std::size_t part = 0; part < parts; ++part) {
    out.insert(out.end(), packed[part].begin(), packed[part].end());
    const std::size_t size = std::min(bytes.size(), (part + 1) * kChunk) - part * kChunk;
    sum = crc32_combine(sum, sums[part], static_cast<z_off_t>(size));
  }
  append_little32(out, sum);
  append_little32(out, bytes.size());
  return out;
}

}  // namespace turgor::scan_io
