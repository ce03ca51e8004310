#include "imaging/scan/dicom_slice.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <limits>

#include "imaging/scan/inflate.hpp"
#include "turgor/core/file.hpp"

namespace turgor::scan_io {
namespace {

/// Headers of CT slices fit in this many bytes but for private groups of unusual size.
constexpr std::size_t kHeaderBytes = std::size_t{256} << 10;
/// Even an empty slice does not pack more pixels than this into a byte of the whole file, header included.
constexpr std::uint64_t kMaxPixelsPerByte = 8192;

std::optional<Vec3> triple(const std::vector<double>& numbers, std::size_t first = 0) {
  if (numbers.size() < first + 3) return std::nullopt;
  return Vec3{numbers[first], numbers[first + 1], numbers[first + 2]};
}

/// Fault text, empty if the layout can be read.
std::string read_layout(const DicomDataSet& set, PixelLayout& layout) {
  const auto rows = set.u16(0x00280010), columns = set.u16(0x00280011), allocated = set.u16(0x00280100);
  if (!rows || !columns || *rows == 0 || *columns == 0 || !allocated) return "holds no image";
  if (set.u16(0x00280002).value_or(1) != 1 || set.text(0x00280004).find("MONOCHROME") == std::string::npos) {
    return "holds a colour picture, not CT values";
  }
  layout.rows = *rows;
  layout.columns = *columns;
  layout.bits_allocated = *allocated;
  layout.bits_stored = set.u16(0x00280101).value_or(*allocated);
  layout.high_bit = set.u16(0x00280102).value_or(static_cast<std::uint16_t>(layout.bits_stored - 1));
  layout.is_signed = set.u16(0x00280103).value_or(0) == 1;
  const bool allocation_known =
      layout.bits_allocated == 8 || layout.bits_allocated == 16 || layout.bits_allocated == 32;
  if (!allocation_known || layout.bits_stored < 1 || layout.bits_stored > layout.bits_allocated ||
      layout.high_bit >= layout.bits_allocated || layout.high_bit + 1 < layout.bits_stored) {
    return fmt::format("states an impossible pixel layout ({} bits stored in {}, highest bit {})",
                       layout.bits_stored, layout.bits_allocated, layout.high_bit);
  }
  return {};
}

std::string read_place(const std::vector<double>& position, const std::vector<double>& orientation,
                       const std::vector<double>& spacing, DicomSlice& slice) {
  const auto origin = triple(position), row = triple(orientation), column = triple(orientation, 3);
  if (!origin || !row || !column) return "states no position and orientation";
  if (spacing.size() < 2 || !(spacing[0] > 0) || !(spacing[1] > 0)) return "states no pixel spacing";
  const Vec3 along = normalized(*row), down = normalized(*column);
  if (std::abs(length(*row) - 1) > 0.01 || std::abs(length(*column) - 1) > 0.01 ||
      std::abs(dot(along, down)) > 0.01) {
    return "states row and column directions that are not at right angles";
  }
  slice.position = *origin;
  slice.row_step = along * spacing[1];
  slice.column_step = down * spacing[0];
  return {};
}

std::string read_rescale(const DicomDataSet& set, DicomSlice& slice) {
  slice.slope = set.number(0x00281053).value_or(1);
  slice.intercept = set.number(0x00281052).value_or(0);
  return slice.slope == 0 ? "states a rescale slope of zero" : "";
}

void read_padding(const DicomDataSet& set, DicomSlice& slice) {
  const auto low = set.u16(0x00280120);
  if (!low) return;
  const auto value = [&](std::uint16_t raw) {
    return slice.layout.is_signed ? int{static_cast<std::int16_t>(raw)} : int{raw};
  };
  const int first = value(*low), second = value(set.u16(0x00280121).value_or(*low));
  slice.has_padding = true;
  slice.padding_low = std::min(first, second);
  slice.padding_high = std::max(first, second);
}

/// Functional groups of enhanced multi-frame objects (PS3.3 C.7.6.16): per frame, else shared by all.
class FrameGroups {
 public:
  explicit FrameGroups(const DicomDataSet& set)
      : shared_(set.item(0x52009229)), frames_(set.items(0x52009230)) {}
  [[nodiscard]] std::size_t frames() const { return frames_.size(); }
  [[nodiscard]] DicomDataSet group(std::size_t frame, DicomTag sequence) const {
    DicomDataSet own = frames_[frame].item(sequence);
    return own.empty() ? shared_.item(sequence) : own;
  }

 private:
  DicomDataSet shared_;
  std::vector<DicomDataSet> frames_;
};

std::string read_frames(const DicomDataSet& set, const DicomSlice& common, int frames,
                        std::vector<DicomSlice>& slices) {
  const FrameGroups groups(set);
  if (groups.frames() != static_cast<std::size_t>(frames)) {
    return fmt::format("holds {} frames without a position for each", frames);
  }
  for (int f = 0; f < frames; ++f) {
    const auto at = static_cast<std::size_t>(f);
    DicomSlice slice = common;
    slice.frame = f;
    std::string fault = read_place(groups.group(at, 0x00209113).numbers(0x00200032),
                                   groups.group(at, 0x00209116).numbers(0x00200037),
                                   groups.group(at, 0x00289110).numbers(0x00280030), slice);
    if (fault.empty()) fault = read_rescale(groups.group(at, 0x00289145), slice);
    if (!fault.empty()) return fault + fmt::format(" in frame {}", f + 1);
    slices.push_back(slice);
  }
  return {};
}

/// Fault text where the file cannot hold the pixels that its header states.
std::string check_amount(const DicomFileHeader& header, const DicomDataSet& set, const PixelLayout& layout,
                         int frames, std::uint64_t file_size) {
  const DicomElement* pixels = set.find(kPixelData);
  if (pixels == nullptr) return "holds no pixels";
  const std::uint64_t count = static_cast<std::uint64_t>(layout.rows) *
                              static_cast<std::uint64_t>(layout.columns) * static_cast<std::uint64_t>(frames);
  if (header.encapsulated || pixels->undefined_length) {
    return count / kMaxPixelsPerByte > file_size ? "is too small for the image size it states" : "";
  }
  const std::uint64_t needed = count * static_cast<std::uint64_t>(layout.bits_allocated / 8);
  if (pixels->stated_length < needed) return "holds fewer pixels than its image size";
  if (!header.deflated && file_size - pixels->value_offset < needed) return "is cut short";
  return {};
}

DicomFileOutcome faulty(std::string fault, bool not_dicom = false) {
  return {std::nullopt, std::move(fault), not_dicom};
}

DicomFileOutcome describe(const DicomFileHeader& header, const DicomDataSet& set, std::uint64_t file_size,
                          const std::filesystem::path& path) {
  if (set.find(kPixelData) == nullptr && !set.whole()) return faulty("is cut short or damaged");
  DicomSlice slice;
  slice.path = path;
  if (std::string fault = read_layout(set, slice.layout); !fault.empty()) return faulty(std::move(fault));
  const double stated_frames = set.number(0x00280008).value_or(1);
  const int frames = stated_frames >= 1 && stated_frames <= 65536 ? static_cast<int>(stated_frames) : 1;
  slice.frames_in_file = frames;
  if (std::string fault = check_amount(header, set, slice.layout, frames, file_size); !fault.empty()) {
    return faulty(std::move(fault));
  }
  read_padding(set, slice);
  DicomFileInfo info;
  std::string fault;
  if (set.find(0x52009229) != nullptr || set.find(0x52009230) != nullptr || frames > 1) {
    fault = read_frames(set, slice, frames, info.slices);
  } else {
    fault = read_place(set.numbers(0x00200032), set.numbers(0x00200037), set.numbers(0x00280030), slice);
    if (fault.empty()) fault = read_rescale(set, slice);
    info.slices.push_back(slice);
  }
  if (!fault.empty()) return faulty(std::move(fault));
  info.series_uid = set.text(0x0020000E);
  info.series_description = set.text(0x0008103E);
  info.study_description = set.text(0x00081030);
  info.patient = set.text(0x00100010);
  info.modality = set.text(0x00080060);
  info.localizer = set.text(0x00080008).find("LOCALIZER") != std::string::npos;
  return {std::move(info), {}, false};
}

/// Up to `limit` bytes from the start of a file; nullopt if it is not a readable regular file.
std::optional<std::vector<std::byte>> read_beginning(const std::filesystem::path& path, std::size_t limit,
                                                     std::uint64_t& file_size) {
  // Opening a device can do something, such as wind a tape; so it is asked first.
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return std::nullopt;
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return std::nullopt;
  struct stat status {};
  std::optional<std::vector<std::byte>> bytes;
  if (::fstat(fd, &status) == 0 && S_ISREG(status.st_mode)) {
    file_size = static_cast<std::uint64_t>(status.st_size);
    bytes.emplace(static_cast<std::size_t>(std::min<std::uint64_t>(limit, file_size)));
    std::size_t done = 0;
    while (done < bytes->size()) {
      const ssize_t got = ::read(fd, bytes->data() + done, bytes->size() - done);
      if (got <= 0) break;
      done += static_cast<std::size_t>(got);
    }
    bytes->resize(done);
  }
  ::close(fd);
  return bytes;
}

}  // namespace

DicomFileOutcome parse_dicom_info(Bytes bytes, std::uint64_t file_size, const std::filesystem::path& path,
                                  bool* needs_more) {
  const auto header = parse_dicom_header(bytes);
  if (!header) return faulty("is not a DICOM file", true);
  const bool partial = bytes.size() < file_size;
  if (header->deflated) {
    if (partial && needs_more != nullptr) {
      *needs_more = true;
      return {};
    }
    const Inflated plain =
        inflate_bytes(bytes.subspan(header->data_set_start), std::size_t{1} << 31, Deflate::raw);
    return describe(*header, DicomDataSet::parse(plain.bytes, 0, header->encoding), plain.bytes.size(), path);
  }
  const auto set = DicomDataSet::parse(bytes, header->data_set_start, header->encoding);
  if (partial && needs_more != nullptr && set.find(kPixelData) == nullptr) {
    *needs_more = true;
    return {};
  }
  return describe(*header, set, file_size, path);
}

DicomFileOutcome read_dicom_info(const std::filesystem::path& path) {
  std::uint64_t size = 0;
  const auto beginning = read_beginning(path, kHeaderBytes, size);
  if (!beginning) return faulty("cannot be read", true);
  bool needs_more = false;
  DicomFileOutcome outcome = parse_dicom_info(*beginning, size, path, &needs_more);
  if (!needs_more) return outcome;
  const auto all = read_file(path);
  if (!all) return faulty("cannot be read");
  return parse_dicom_info(*all, all->size(), path);
}

}  // namespace turgor::scan_io
