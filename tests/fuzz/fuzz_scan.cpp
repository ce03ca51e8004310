// Scan readers on arbitrary bytes, from memory. The first byte chooses the format; see Format below.
#include <cstdint>
#include <cstdlib>
#include <span>

#include "imaging/scan/dicom_codecs.hpp"
#include "imaging/scan/dicom_stack.hpp"
#include "imaging/scan/readers.hpp"

namespace {
using namespace turgor;
using namespace turgor::scan_io;

enum Format : unsigned { nrrd, nifti, metaimage, inv3, dicom, rle, jpeg, jpeg_ls, jpeg_2000, formats };

const std::filesystem::path kPath = "/nonexistent/scan";

void require(bool holds) {
  if (!holds) std::abort();
}

void check(Result<StoredVolume> stored, Context& context) {
  if (!stored) {
    require(!stored.error().what.empty() && !stored.error().where.empty());
    return;
  }
  require(stored->voxels.size() == voxel_count(stored->size));
  const auto scan = to_canonical(*std::move(stored), kPath, context);
  if (!scan) return;
  const Grid& grid = scan->hu.grid;
  require(scan->hu.voxels.size() == grid.voxel_count());
  require(is_finite(grid.origin) && grid.direction.determinant() > 0.999);
}

/// Header, the first frames' pixels, and the stack that the frames make.
void read_dicom_file(Bytes bytes) {
  const DicomFileOutcome outcome = parse_dicom_info(bytes, bytes.size(), kPath);
  if (!outcome.info) {
    require(!outcome.fault.empty());
    return;
  }
  for (std::size_t n = 0; n < std::min<std::size_t>(outcome.info->slices.size(), 3); ++n) {
    const DicomSlice& slice = outcome.info->slices[n];
    std::vector<std::int16_t> out(static_cast<std::size_t>(slice.layout.rows) *
                                  static_cast<std::size_t>(slice.layout.columns));
    (void)static_cast<bool>(read_dicom_pixels(slice, bytes, out));
  }
  (void)static_cast<bool>(stack_slices(outcome.info->slices, kPath));
}

/// Two bytes of size, one of depth, then the stream.
void decode(Format format, Bytes bytes) {
  if (bytes.size() < 3) return;
  PixelLayout layout;
  layout.columns = static_cast<int>(bytes[0]) + 1;
  layout.rows = static_cast<int>(bytes[1]) + 1;
  layout.bits_allocated = (bytes[2] & std::byte{1}) == std::byte{} ? 16 : 8;
  const Bytes coded = bytes.subspan(3);
  const auto samples = format == rle       ? decode_rle(coded, layout)
                       : format == jpeg    ? decode_jpeg(coded, layout)
                       : format == jpeg_ls ? decode_jpeg_ls(coded, layout)
                                           : decode_jpeg_2000(coded, layout);
  if (samples) require(samples->size() == static_cast<std::size_t>(layout.rows * layout.columns));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const Bytes bytes = std::as_bytes(std::span(data + 1, size - 1));
  const SourceFile file{kPath, bytes};
  Context context;
  switch (const unsigned format = data[0] % formats; format) {
    case nrrd:
      check(read_nrrd(file, context), context);
      break;
    case nifti:
      check(read_nifti(file, context), context);
      break;
    case metaimage:
      check(read_metaimage(file, context), context);
      break;
    case inv3:
      check(read_inv3(file, context), context);
      break;
    case dicom:
      read_dicom_file(bytes);
      break;
    default:
      decode(static_cast<Format>(format), bytes);
  }
  return 0;
}
