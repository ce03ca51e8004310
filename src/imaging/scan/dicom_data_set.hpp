// DICOM data sets in memory (PS3.5): elements in order, sequences opened only when asked for. Every length is
// held against the bytes there are, so damaged files end in an error and never in a read beyond the buffer.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace turgor::scan_io {

using Bytes = std::span<const std::byte>;

/// (group, element) as one number, 0xGGGGEEEE.
using DicomTag = std::uint32_t;
inline constexpr DicomTag kPixelData = 0x7FE00010;

/// How the elements of a data set are written.
struct DicomEncoding {
  bool explicit_vr = true;
  bool big_endian = false;
};

struct DicomElement {
  DicomTag tag = 0;
  Bytes value;  ///< without padding removed; up to the delimiter where the length is undefined
  bool undefined_length = false;
  bool cut = false;  ///< the stated length, or the delimiter, lies beyond the end of the bytes
  std::uint64_t stated_length = 0;
  std::size_t value_offset = 0;  ///< of `value` from the start of the bytes parsed
  DicomEncoding encoding;        ///< of items inside, if it is a sequence
};

class DicomDataSet {
 public:
  /// Reads elements until the pixel data (which becomes the last element) or the end.
  static DicomDataSet parse(Bytes bytes, std::size_t start, DicomEncoding encoding);

  [[nodiscard]] const DicomElement* find(DicomTag tag) const;
  /// False where an element's length ran over the end before the pixel data were reached.
  [[nodiscard]] bool whole() const { return whole_; }
  [[nodiscard]] bool empty() const { return elements_.empty(); }

  /// Text without padding; empty if absent.
  [[nodiscard]] std::string text(DicomTag tag) const;
  /// Decimal or integer strings separated by backslashes; empty if absent or not numbers.
  [[nodiscard]] std::vector<double> numbers(DicomTag tag) const;
  [[nodiscard]] std::optional<double> number(DicomTag tag) const;
  /// Binary unsigned 16-bit value.
  [[nodiscard]] std::optional<std::uint16_t> u16(DicomTag tag) const;
  /// The items of a sequence; empty if absent.
  [[nodiscard]] std::vector<DicomDataSet> items(DicomTag tag) const;
  /// The first item, or an empty data set.
  [[nodiscard]] DicomDataSet item(DicomTag tag) const;

 private:
  std::vector<DicomElement> elements_;
  bool whole_ = true;
};

/// Where the data set of a DICOM file starts, and how it is written.
struct DicomFileHeader {
  std::string transfer_syntax;  ///< UID; empty if the file states none
  DicomEncoding encoding;
  bool deflated = false;
  bool encapsulated = false;  ///< pixel data lie in fragments, usually compressed
  std::size_t data_set_start = 0;
};

/// Reads preamble and file meta information; files without them are recognised by their first element.
/// nullopt: not DICOM.
std::optional<DicomFileHeader> parse_dicom_header(Bytes bytes);

/// The fragments of encapsulated pixel data. The first is the offset table (may be empty). nullopt: damaged.
std::optional<std::vector<Bytes>> dicom_fragments(const DicomElement& pixels);

}  // namespace turgor::scan_io
