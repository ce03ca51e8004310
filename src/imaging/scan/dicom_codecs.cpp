#include "imaging/scan/dicom_codecs.hpp"

#include <openjpeg.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>

namespace turgor::scan_io {
namespace {

std::size_t pixel_count(const PixelLayout& layout) {
  return static_cast<std::size_t>(layout.rows) * static_cast<std::size_t>(layout.columns);
}

std::uint32_t load_little32(Bytes b, std::size_t at) {
  return static_cast<std::uint32_t>(b[at]) | static_cast<std::uint32_t>(b[at + 1]) << 8 |
         static_cast<std::uint32_t>(b[at + 2]) << 16 | static_cast<std::uint32_t>(b[at + 3]) << 24;
}
std::uint32_t load_big32(Bytes b, std::size_t at) {
  return static_cast<std::uint32_t>(b[at]) << 24 | static_cast<std::uint32_t>(b[at + 1]) << 16 |
         static_cast<std::uint32_t>(b[at + 2]) << 8 | static_cast<std::uint32_t>(b[at + 3]);
}

/// One PackBits segment; its bytes are shifted into place in `out`. False where it ends early.
bool decode_plane(Bytes coded, std::size_t at, int shift, Samples& out) {
  std::size_t done = 0;
  while (done < out.size() && at < coded.size()) {
    const auto control = static_cast<std::size_t>(coded[at++]);
    if (control == 128) continue;
    const bool literal = control < 128;
    const std::size_t run = literal ? control + 1 : 257 - control;
    const std::size_t source = literal ? run : 1;
    if (source > coded.size() - at) return false;
    const std::size_t used = std::min(run, out.size() - done);
    for (std::size_t i = 0; i < used; ++i) {
      const auto byte = static_cast<std::uint32_t>(coded[at + (literal ? i : 0)]);
      out[done + i] = static_cast<std::uint16_t>(out[done + i] | byte << shift);
    }
    done += used;
    at += source;
  }
  return done == out.size();
}

/// Bytes of a JPEG 2000 stream as OpenJPEG wants to read them.
struct MemoryStream {
  Bytes bytes;
  std::size_t at = 0;

  static OPJ_SIZE_T read(void* buffer, OPJ_SIZE_T size, void* self) {
    auto& s = *static_cast<MemoryStream*>(self);
    const std::size_t count = std::min<std::size_t>(size, s.bytes.size() - s.at);
    if (count == 0) return static_cast<OPJ_SIZE_T>(-1);
    std::memcpy(buffer, s.bytes.data() + s.at, count);
    s.at += count;
    return count;
  }
  static OPJ_OFF_T skip(OPJ_OFF_T size, void* self) {
    auto& s = *static_cast<MemoryStream*>(self);
    if (size < 0 || static_cast<std::uint64_t>(size) > s.bytes.size() - s.at) return -1;
    s.at += static_cast<std::size_t>(size);
    return size;
  }
  static OPJ_BOOL seek(OPJ_OFF_T to, void* self) {
    auto& s = *static_cast<MemoryStream*>(self);
    if (to < 0 || static_cast<std::uint64_t>(to) > s.bytes.size()) return OPJ_FALSE;
    s.at = static_cast<std::size_t>(to);
    return OPJ_TRUE;
  }
};

/// OpenJPEG's handles are pointers to pointers, all of one type to the compiler.
template <void (*destroy)(void**)>
struct HandleDeleter {
  void operator()(void** handle) const { destroy(handle); }
};
struct ImageDeleter {
  void operator()(opj_image_t* image) const { opj_image_destroy(image); }
};
using Stream = std::unique_ptr<opj_stream_t, HandleDeleter<opj_stream_destroy>>;
using Codec = std::unique_ptr<opj_codec_t, HandleDeleter<opj_destroy_codec>>;
using Image = std::unique_ptr<opj_image_t, ImageDeleter>;

constexpr std::array<std::byte, 4> kCodestreamStart{std::byte{0xFF}, std::byte{0x4F}, std::byte{0xFF},
                                                    std::byte{0x51}};

/// The size that the SIZ marker states is held against the layout before OpenJPEG makes room for it.
bool size_marker_fits(Bytes b, const PixelLayout& layout) {
  const auto found = std::search(b.begin(), b.end(), kCodestreamStart.begin(), kCodestreamStart.end());
  const auto at = static_cast<std::size_t>(found - b.begin());
  if (b.size() - at < 43) return false;
  const auto field = [&](std::size_t n) { return load_big32(b, at + 8 + 4 * n); };
  const std::uint32_t right = field(0), bottom = field(1), left = field(2), top = field(3);
  const std::uint64_t tile_width = field(4), tile_height = field(5);
  if (right < left || bottom < top || tile_width == 0 || tile_height == 0) return false;
  const std::uint64_t tiles = (right / tile_width + 1) * (bottom / tile_height + 1);
  const std::uint32_t components = load_big32(b, at + 38) & 0xFFFF;
  return right - left == static_cast<std::uint32_t>(layout.columns) &&
         bottom - top == static_cast<std::uint32_t>(layout.rows) && components == 1 && tiles <= 65535;
}

Stream open_stream(MemoryStream& source) {
  Stream stream(opj_stream_create(std::size_t{1} << 16, OPJ_TRUE));
  if (!stream) return stream;
  opj_stream_set_read_function(stream.get(), MemoryStream::read);
  opj_stream_set_skip_function(stream.get(), MemoryStream::skip);
  opj_stream_set_seek_function(stream.get(), MemoryStream::seek);
  opj_stream_set_user_data(stream.get(), &source, nullptr);
  opj_stream_set_user_data_length(stream.get(), source.bytes.size());
  return stream;
}

}  // namespace

std::optional<Samples> decode_rle(Bytes coded, const PixelLayout& layout) {
  const int planes = layout.bits_allocated / 8;
  if (planes > 2 || coded.size() < 64 || load_little32(coded, 0) != static_cast<std::uint32_t>(planes)) {
    return std::nullopt;
  }
  Samples out(pixel_count(layout));
  for (int plane = 0; plane < planes; ++plane) {  // the most significant byte comes first
    const std::size_t start = load_little32(coded, 4 + 4 * static_cast<std::size_t>(plane));
    if (!decode_plane(coded, start, 8 * (planes - 1 - plane), out)) return std::nullopt;
  }
  return out;
}

std::optional<Samples> decode_jpeg_2000(Bytes coded, const PixelLayout& layout) {
  if (coded.size() < 64 || !size_marker_fits(coded, layout)) return std::nullopt;
  const bool bare = std::equal(kCodestreamStart.begin(), kCodestreamStart.end(), coded.begin());
  MemoryStream source{coded};
  const Stream stream = open_stream(source);
  const Codec codec(opj_create_decompress(bare ? OPJ_CODEC_J2K : OPJ_CODEC_JP2));
  opj_dparameters_t parameters;
  opj_set_default_decoder_parameters(&parameters);
  opj_image_t* raw = nullptr;
  if (!stream || !codec || opj_setup_decoder(codec.get(), &parameters) == OPJ_FALSE ||
      opj_read_header(stream.get(), codec.get(), &raw) == OPJ_FALSE) {
    opj_image_destroy(raw);
    return std::nullopt;
  }
  const Image image(raw);
  const auto fits = [&] {
    const opj_image_comp_t& c = image->comps[0];
    return image->numcomps == 1 && c.dx == 1 && c.dy == 1 && c.w == static_cast<OPJ_UINT32>(layout.columns) &&
           c.h == static_cast<OPJ_UINT32>(layout.rows) &&
           c.prec <= static_cast<OPJ_UINT32>(std::min(layout.bits_allocated, 16));
  };
  if (!fits() || opj_decode(codec.get(), stream.get(), image.get()) == OPJ_FALSE || !fits() ||
      image->comps[0].data == nullptr) {
    return std::nullopt;
  }
  Samples out(pixel_count(layout));
  const OPJ_INT32* data = image->comps[0].data;
  std::transform(data, data + out.size(), out.begin(),
                 [](OPJ_INT32 v) { return static_cast<std::uint16_t>(v); });
  return out;
}

}  // namespace turgor::scan_io
