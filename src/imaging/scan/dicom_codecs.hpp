// Decoders of compressed DICOM pixel data. All but JPEG 2000 are our own: GDCM aborts the program on damaged
// streams (its assertions are compiled in), and none of these coders is long.
#pragma once

#include <optional>
#include <vector>

#include "imaging/scan/dicom_slice.hpp"

namespace turgor::scan_io {

/// Samples as stored, in the low bits; rows × columns of them.
using Samples = std::vector<std::uint16_t>;

/// Each returns nullopt where the stream is damaged or is not of the size in `layout`.
/// PackBits segments (PS3.5 annex G), 8 or 16 bits.
std::optional<Samples> decode_rle(Bytes coded, const PixelLayout& layout);
/// JPEG (ITU-T T.81) of one component, Huffman coded: baseline, extended sequential (8 and 12 bits) and
/// lossless.
std::optional<Samples> decode_jpeg(Bytes coded, const PixelLayout& layout);
/// JPEG-LS (ITU-T T.87) of one component, lossless or near-lossless.
std::optional<Samples> decode_jpeg_ls(Bytes coded, const PixelLayout& layout);
/// JPEG 2000 (ITU-T T.800) of one component, by OpenJPEG.
std::optional<Samples> decode_jpeg_2000(Bytes coded, const PixelLayout& layout);

}  // namespace turgor::scan_io
