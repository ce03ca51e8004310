// Pixels of DICOM slices to Hounsfield units, native or compressed.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "imaging/scan/dicom_codecs.hpp"
#include "imaging/scan/dicom_slice.hpp"
#include "imaging/scan/inflate.hpp"

namespace turgor::scan_io {
namespace {

std::size_t frame_bytes(const PixelLayout& layout) {
  return static_cast<std::size_t>(layout.rows) * static_cast<std::size_t>(layout.columns) *
         static_cast<std::size_t>(layout.bits_allocated / 8);
}

std::uint32_t load_little32(Bytes b, std::size_t at) {
  return static_cast<std::uint32_t>(b[at]) | static_cast<std::uint32_t>(b[at + 1]) << 8 |
         static_cast<std::uint32_t>(b[at + 2]) << 16 | static_cast<std::uint32_t>(b[at + 3]) << 24;
}

using Decoder = std::optional<Samples> (*)(Bytes, const PixelLayout&);

/// nullptr: a transfer syntax that is not supported.
Decoder decoder_for(std::string_view uid) {
  constexpr std::string_view jpeg = "1.2.840.10008.1.2.4.";
  if (uid == "1.2.840.10008.1.2.5") return decode_rle;
  if (!uid.starts_with(jpeg)) return nullptr;
  uid.remove_prefix(jpeg.size());
  if (uid == "50" || uid == "51" || uid == "57" || uid == "70") return decode_jpeg;
  if (uid == "80" || uid == "81") return decode_jpeg_ls;
  if (uid == "90" || uid == "91") return decode_jpeg_2000;
  return nullptr;
}

/// The coded stream of one frame: its own fragments, by the offset table where a frame has several.
std::optional<std::vector<std::byte>> coded_frame(const DicomElement& pixels, int frame, int frames) {
  const auto fragments = dicom_fragments(pixels);
  if (!fragments || fragments->size() < 2) return std::nullopt;
  const std::size_t count = fragments->size() - 1;
  std::size_t first = 0, end = count;
  if (count == static_cast<std::size_t>(frames)) {
    first = static_cast<std::size_t>(frame), end = first + 1;
  } else if (frames > 1) {
    const Bytes table = fragments->front();
    if (table.size() < 4 * static_cast<std::size_t>(frames)) return std::nullopt;
    const auto starts_at = [&](int f) {
      return std::uint64_t{load_little32(table, 4 * static_cast<std::size_t>(f))};
    };
    const std::uint64_t from = starts_at(frame);
    const std::uint64_t to = frame + 1 < frames ? starts_at(frame + 1) : ~std::uint64_t{0};
    first = end = count;
    std::uint64_t offset = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (offset == from) first = i;
      if (offset >= to) {
        end = i;
        break;
      }
      offset += 8 + (*fragments)[i + 1].size();
    }
  }
  if (first >= end) return std::nullopt;
  std::vector<std::byte> coded;
  for (std::size_t i = first; i < end; ++i) {
    coded.insert(coded.end(), (*fragments)[i + 1].begin(), (*fragments)[i + 1].end());
  }
  return coded;
}

Result<Samples> decode_frame(const DicomSlice& slice, const DicomElement& pixels, const std::string& syntax) {
  const Decoder decode = decoder_for(syntax);
  if (decode == nullptr) {
    return bad_file(slice.path, fmt::format("uses the transfer syntax {}, which is not supported", syntax),
                    "Convert the series to an uncompressed transfer syntax");
  }
  if (pixels.cut) return bad_file(slice.path, "is cut short", "Copy the file again from its source");
  const auto coded = coded_frame(pixels, slice.frame, slice.frames_in_file);
  auto samples = coded && slice.layout.bits_allocated <= 16 ? decode(*coded, slice.layout) : std::nullopt;
  if (!samples) {
    return bad_file(slice.path, "its compressed pixels are damaged", "Copy the file again from its source");
  }
  return *std::move(samples);
}

/// Stored bits to Hounsfield units: shift, mask, sign, rescale, padding.
template <int width>
ValueLosses rescale(Bytes bytes, bool big_endian, const DicomSlice& slice, std::span<std::int16_t> out) {
  const PixelLayout& layout = slice.layout;
  const int shift = layout.high_bit + 1 - layout.bits_stored;
  const std::uint32_t mask = static_cast<std::uint32_t>((std::uint64_t{1} << layout.bits_stored) - 1);
  const std::uint32_t sign = layout.is_signed ? 1U << (layout.bits_stored - 1) : 0;
  ValueLosses losses;
  for (std::size_t n = 0; n < out.size(); ++n) {
    std::uint32_t raw = 0;
    for (int b = 0; b < width; ++b) {
      const std::size_t place = n * width + static_cast<std::size_t>(big_endian ? width - 1 - b : b);
      raw |= static_cast<std::uint32_t>(bytes[place]) << (8 * b);
    }
    raw = raw >> shift & mask;
    const std::int64_t stored = std::int64_t{raw ^ sign} - std::int64_t{sign};
    const double hu = std::floor(static_cast<double>(stored) * slice.slope + slice.intercept + 0.5);
    if (slice.has_padding && hu < kAirHu && stored >= slice.padding_low && stored <= slice.padding_high) {
      out[n] = kAirHu;  // outside the scanner's circle; some scanners put values far below air there
    } else if (hu >= -32768.0 && hu <= 32767.0) {
      out[n] = static_cast<std::int16_t>(hu);
    } else {
      out[n] = hu < 0 ? std::int16_t{-32768} : std::int16_t{32767};
      ++losses.clamped;
    }
  }
  return losses;
}

ValueLosses rescale_any(Bytes bytes, bool big_endian, const DicomSlice& slice, std::span<std::int16_t> out) {
  switch (slice.layout.bits_allocated) {
    case 8:
      return rescale<1>(bytes, big_endian, slice, out);
    case 16:
      return rescale<2>(bytes, big_endian, slice, out);
    default:
      return rescale<4>(bytes, big_endian, slice, out);
  }
}

}  // namespace

Result<ValueLosses> read_dicom_pixels(const DicomSlice& slice, Bytes bytes, std::span<std::int16_t> out) {
  const Error changed =
      bad_file(slice.path, "is cut short or has changed while it was read", "Copy the file again");
  const auto header = parse_dicom_header(bytes);
  if (!header) return changed;
  std::vector<std::byte> plain;
  std::size_t start = header->data_set_start;
  if (header->deflated) {
    plain = inflate_bytes(bytes.subspan(start), std::size_t{1} << 31, Deflate::raw).bytes;
    bytes = plain;
    start = 0;
  }
  const auto set = DicomDataSet::parse(bytes, start, header->encoding);
  const DicomElement* pixels = set.find(kPixelData);
  if (pixels == nullptr) return changed;
  if (header->encapsulated || pixels->undefined_length) {
    TURGOR_TRY(const Samples samples, decode_frame(slice, *pixels, header->transfer_syntax));
    return rescale<2>(std::as_bytes(std::span(samples)), false, slice, out);
  }
  const std::size_t size = frame_bytes(slice.layout);
  const std::size_t first = size * static_cast<std::size_t>(slice.frame);
  if (pixels->value.size() < first + size) return changed;
  return rescale_any(pixels->value.subspan(first, size), header->encoding.big_endian, slice, out);
}

}  // namespace turgor::scan_io
