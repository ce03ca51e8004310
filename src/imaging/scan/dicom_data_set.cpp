#include "imaging/scan/dicom_data_set.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string_view>

namespace turgor::scan_io {
namespace {

constexpr DicomTag kItem = 0xFFFEE000, kItemEnd = 0xFFFEE00D, kSequenceEnd = 0xFFFEE0DD;
constexpr std::uint32_t kUndefined = 0xFFFFFFFF;
constexpr int kMaxDepth = 32;

std::uint32_t load_u16(Bytes b, std::size_t at, bool big) {
  const auto lo = static_cast<std::uint32_t>(b[at]), hi = static_cast<std::uint32_t>(b[at + 1]);
  return big ? lo << 8 | hi : hi << 8 | lo;
}
std::uint32_t load_u32(Bytes b, std::size_t at, bool big) {
  const std::uint32_t first = load_u16(b, at, big), second = load_u16(b, at + 2, big);
  return big ? first << 16 | second : second << 16 | first;
}
DicomTag load_tag(Bytes b, std::size_t at, bool big) {
  return load_u16(b, at, big) << 16 | load_u16(b, at + 2, big);
}

bool is_vr(Bytes b, std::size_t at) {
  const auto upper = [&](std::size_t i) { return b[i] >= std::byte{'A'} && b[i] <= std::byte{'Z'}; };
  return upper(at) && upper(at + 1);
}
/// Representations whose explicit form has two reserved bytes and a 32-bit length.
bool has_long_length(std::string_view vr) {
  static constexpr std::array<std::string_view, 12> names{"OB", "OD", "OF", "OL", "OV", "OW",
                                                          "SQ", "SV", "UC", "UN", "UR", "UT"};
  return std::find(names.begin(), names.end(), vr) != names.end();
}

struct ElementHead {
  DicomTag tag;
  std::uint32_t length;
  std::size_t value;        // offset of the value
  bool unknown_vr = false;  // UN: items inside are implicit little endian (CP-246)
};

/// nullopt where the head runs over the end.
std::optional<ElementHead> read_head(Bytes b, std::size_t at, DicomEncoding encoding) {
  const bool big = encoding.big_endian;
  if (b.size() < 8 || at > b.size() - 8) return std::nullopt;
  const DicomTag tag = load_tag(b, at, big);
  // Delimiters and items have no representation; some writers also slip implicit elements into explicit sets.
  if (!encoding.explicit_vr || tag >> 16 == 0xFFFE || !is_vr(b, at + 4)) {
    return ElementHead{tag, load_u32(b, at + 4, big), at + 8};
  }
  const std::string_view vr(reinterpret_cast<const char*>(b.data()) + at + 4, 2);
  if (!has_long_length(vr)) return ElementHead{tag, load_u16(b, at + 6, big), at + 8};
  if (b.size() - at < 12) return std::nullopt;
  return ElementHead{tag, load_u32(b, at + 8, big), at + 12, vr == "UN"};
}

/// Offset just behind the delimiter of a sequence (or item) of undefined length that starts at `at`.
std::optional<std::size_t> skip_undefined(Bytes b, std::size_t at, DicomEncoding encoding, DicomTag end,
                                          int depth) {
  if (depth > kMaxDepth) return std::nullopt;
  for (;;) {
    const auto head = read_head(b, at, encoding);
    if (!head) return std::nullopt;
    if (head->tag == end) return head->value;
    if (head->length == kUndefined) {
      const bool item = head->tag == kItem;
      const DicomEncoding inner = head->unknown_vr ? DicomEncoding{false, false} : encoding;
      const auto next = skip_undefined(b, head->value, inner, item ? kItemEnd : kSequenceEnd, depth + 1);
      if (!next) return std::nullopt;
      at = *next;
    } else {
      if (head->length > b.size() - head->value) return std::nullopt;
      at = head->value + head->length;
    }
  }
}

/// `offset` is where the element's head starts in the whole; advances it.
std::optional<DicomElement> read_element(Bytes b, std::size_t& at, DicomEncoding encoding) {
  const auto head = read_head(b, at, encoding);
  if (!head) return std::nullopt;
  DicomElement element;
  element.tag = head->tag;
  element.value_offset = head->value;
  element.stated_length = head->length;
  element.encoding = head->unknown_vr ? DicomEncoding{false, false} : encoding;
  const std::size_t rest = b.size() - head->value;
  if (head->length == kUndefined) {
    element.undefined_length = true;
    const auto end = skip_undefined(b, head->value, element.encoding, kSequenceEnd, 0);
    element.cut = !end;
    at = end.value_or(b.size());
    element.value = b.subspan(head->value, end ? *end - 8 - head->value : rest);
  } else {
    element.cut = head->length > rest;
    element.value = b.subspan(head->value, std::min<std::size_t>(head->length, rest));
    at = head->value + element.value.size();
  }
  return element;
}

std::string_view as_text(Bytes value) {
  return {reinterpret_cast<const char*>(value.data()), value.size()};
}

}  // namespace

DicomDataSet DicomDataSet::parse(Bytes bytes, std::size_t start, DicomEncoding encoding) {
  DicomDataSet set;
  std::size_t at = start;
  while (at < bytes.size()) {
    const auto element = read_element(bytes, at, encoding);
    if (!element) {
      set.whole_ = false;
      break;
    }
    if (element->tag == kItemEnd || element->tag == kSequenceEnd) break;
    set.elements_.push_back(*element);
    if (element->tag == kPixelData) break;
    if (element->cut) {
      set.whole_ = false;
      break;
    }
  }
  return set;
}

const DicomElement* DicomDataSet::find(DicomTag tag) const {
  for (const DicomElement& element : elements_) {
    if (element.tag == tag) return &element;
  }
  return nullptr;
}

std::string DicomDataSet::text(DicomTag tag) const {
  const DicomElement* element = find(tag);
  if (element == nullptr) return {};
  std::string_view value = as_text(element->value);
  const auto padding = [](char c) { return c == ' ' || c == '\0'; };
  while (!value.empty() && padding(value.back())) value.remove_suffix(1);
  while (!value.empty() && padding(value.front())) value.remove_prefix(1);
  return std::string(value);
}

std::vector<double> DicomDataSet::numbers(DicomTag tag) const {
  std::vector<double> values;
  const std::string all = text(tag);
  for (std::size_t begin = 0; begin < all.size() && values.size() < 64;) {
    const std::size_t end = std::min(all.find('\\', begin), all.size());
    const std::string part = all.substr(begin, end - begin);
    char* stop = nullptr;
    const double value = std::strtod(part.c_str(), &stop);
    if (stop == part.c_str() || !std::isfinite(value)) return {};
    values.push_back(value);
    begin = end + 1;
  }
  return values;
}

std::optional<double> DicomDataSet::number(DicomTag tag) const {
  const auto values = numbers(tag);
  return values.empty() ? std::nullopt : std::optional(values.front());
}

std::optional<std::uint16_t> DicomDataSet::u16(DicomTag tag) const {
  const DicomElement* element = find(tag);
  if (element == nullptr || element->value.size() < 2) return std::nullopt;
  return static_cast<std::uint16_t>(load_u16(element->value, 0, element->encoding.big_endian));
}

std::vector<DicomDataSet> DicomDataSet::items(DicomTag tag) const {
  std::vector<DicomDataSet> sets;
  const DicomElement* sequence = find(tag);
  if (sequence == nullptr) return sets;
  const Bytes b = sequence->value;
  std::size_t at = 0;
  while (at < b.size()) {
    const auto head = read_head(b, at, sequence->encoding);
    if (!head || head->tag != kItem) break;
    if (head->length == kUndefined) {
      const auto end = skip_undefined(b, head->value, sequence->encoding, kItemEnd, 0);
      if (!end) break;
      sets.push_back(parse(b.subspan(0, *end), head->value, sequence->encoding));
      at = *end;
    } else {
      if (head->length > b.size() - head->value) break;
      sets.push_back(parse(b.subspan(0, head->value + head->length), head->value, sequence->encoding));
      at = head->value + head->length;
    }
  }
  return sets;
}

DicomDataSet DicomDataSet::item(DicomTag tag) const {
  auto all = items(tag);
  return all.empty() ? DicomDataSet{} : std::move(all.front());
}

namespace {

void describe_syntax(DicomFileHeader& header) {
  const std::string& uid = header.transfer_syntax;
  static constexpr std::string_view implicit = "1.2.840.10008.1.2", explicit_little = "1.2.840.10008.1.2.1",
                                    deflated = "1.2.840.10008.1.2.1.99", big = "1.2.840.10008.1.2.2";
  header.encoding = {uid != implicit, uid == big};
  header.deflated = uid == deflated;
  header.encapsulated = uid != implicit && uid != explicit_little && uid != deflated && uid != big;
}

/// A bare data set: its first element is of group 0002 or 0008 with a plausible length.
std::optional<DicomFileHeader> guess_bare(Bytes bytes) {
  if (bytes.size() < 16) return std::nullopt;
  const std::uint32_t group = load_u16(bytes, 0, false);
  if (group != 0x0008) return std::nullopt;
  DicomFileHeader header;
  header.encoding = {is_vr(bytes, 4), false};
  const auto head = read_head(bytes, 0, header.encoding);
  if (!head || head->length > 1024) return std::nullopt;
  header.transfer_syntax = header.encoding.explicit_vr ? "1.2.840.10008.1.2.1" : "1.2.840.10008.1.2";
  return header;
}

}  // namespace

std::optional<DicomFileHeader> parse_dicom_header(Bytes bytes) {
  std::size_t at = 132;
  if (bytes.size() < 132 || std::memcmp(bytes.data() + 128, "DICM", 4) != 0) {
    if (bytes.size() < 8 || load_tag(bytes, 0, false) >> 16 != 0x0002) return guess_bare(bytes);
    at = 0;
  }
  DicomFileHeader header;
  // The meta information is always explicit little endian; its stated length is often wrong, its group is
  // not.
  while (at + 8 <= bytes.size() && load_u16(bytes, at, false) == 0x0002) {
    const auto element = read_element(bytes, at, {});
    if (!element || element->cut) return std::nullopt;
    if (element->tag == 0x00020010) {
      header.transfer_syntax = as_text(element->value);
      while (!header.transfer_syntax.empty() &&
             (header.transfer_syntax.back() == '\0' || header.transfer_syntax.back() == ' ')) {
        header.transfer_syntax.pop_back();
      }
    }
  }
  header.data_set_start = at;
  if (!header.transfer_syntax.empty()) {
    describe_syntax(header);
  } else if (bytes.size() >= at + 8) {
    header.encoding.explicit_vr = is_vr(bytes, at + 4);
  }
  return header;
}

std::optional<std::vector<Bytes>> dicom_fragments(const DicomElement& pixels) {
  std::vector<Bytes> fragments;
  const Bytes b = pixels.value;
  std::size_t at = 0;
  while (at < b.size()) {
    const auto head = read_head(b, at, {});
    if (!head || head->tag != kItem || head->length > b.size() - head->value) return std::nullopt;
    fragments.push_back(b.subspan(head->value, head->length));
    at = head->value + head->length;
  }
  return fragments;
}

}  // namespace turgor::scan_io
