#include "imaging/scan/header_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "imaging/scan/inflate.hpp"

namespace turgor::scan_io {
namespace {

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\v' || c == '\f';
}

template <class T>
std::optional<std::vector<T>> parse_all(std::string_view text) {
  std::vector<T> values;
  for (std::string_view word : words(text)) {
    if (word.starts_with('+')) word.remove_prefix(1);
    T value{};
    const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (code != std::errc{} || end != word.data() + word.size()) return std::nullopt;
    values.push_back(value);
  }
  return values;
}

Error too_short(const DataBlock& block, const StoredVolume& stored) {
  return bad_file(block.path,
                  fmt::format("holds fewer voxels than its size {} × {} × {}", stored.size[0], stored.size[1],
                              stored.size[2]),
                  "The file is cut short: copy or export it again");
}

Result<void> read_raw(std::span<const std::byte> bytes, const DataBlock& block, StoredVolume& stored) {
  const std::size_t needed = voxel_count(stored.size) * scalar_bytes(block.format.type);
  if (bytes.size() < needed) return too_short(block, stored);
  const std::size_t spare = bytes.size() - needed;
  if (block.skip > 0 && static_cast<std::uint64_t>(block.skip) > spare) return too_short(block, stored);
  const std::size_t skip = block.skip < 0 ? spare : static_cast<std::size_t>(block.skip);
  stored.voxels.resize(voxel_count(stored.size));
  stored.losses = to_hounsfield(bytes.subspan(skip, needed), block.format, stored.voxels);
  return {};
}

Result<void> read_ascii(std::span<const std::byte> bytes, const DataBlock& block, StoredVolume& stored,
                        const Context& context) {
  const std::size_t count = voxel_count(stored.size);
  if (block.skip > 0 && static_cast<std::uint64_t>(block.skip) > bytes.size())
    return too_short(block, stored);
  const char* at = reinterpret_cast<const char*>(bytes.data()) + std::max<std::int64_t>(block.skip, 0);
  const char* const end = reinterpret_cast<const char*>(bytes.data()) + bytes.size();
  if (static_cast<std::size_t>(end - at) / 2 + 1 < count) return too_short(block, stored);
  stored.voxels.resize(count);
  // Numbers of any written form; the stored type does not matter any more.
  const ScalarFormat as_double{ScalarType::float64, false, block.format.slope, block.format.intercept};
  for (std::size_t n = 0; n < count; ++n) {
    if (n % (1 << 20) == 0) TURGOR_CHECK(context.check());
    while (at < end && (is_space(*at) || *at == ',')) ++at;
    if (at == end) return too_short(block, stored);
    if (*at == '+') ++at;
    double value = 0;
    const auto [next, code] = std::from_chars(at, end, value);
    if (code != std::errc{}) {
      return bad_file(block.path, fmt::format("its value number {} is not a number", n + 1),
                      "Export the file again");
    }
    at = next;
    stored.losses += to_hounsfield(std::as_bytes(std::span(&value, 1)), as_double, {&stored.voxels[n], 1});
  }
  return {};
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  return text;
}

std::vector<std::string_view> words(std::string_view text) {
  std::vector<std::string_view> found;
  std::size_t at = 0;
  while (at < text.size()) {
    if (is_space(text[at])) {
      ++at;
      continue;
    }
    std::size_t end = at;
    while (end < text.size() && !is_space(text[end])) ++end;
    found.push_back(text.substr(at, end - at));
    at = end;
  }
  return found;
}

std::optional<std::vector<double>> numbers(std::string_view text) {
  auto values = parse_all<double>(text);
  if (values && std::any_of(values->begin(), values->end(), [](double v) { return !std::isfinite(v); })) {
    return std::nullopt;
  }
  return values;
}

std::optional<std::vector<std::int64_t>> whole_numbers(std::string_view text) {
  return parse_all<std::int64_t>(text);
}

std::optional<std::string_view> LineReader::next() {
  if (at_ >= text_.size()) return std::nullopt;
  const std::size_t end = text_.find('\n', at_);
  std::string_view line = text_.substr(at_, end == std::string_view::npos ? end : end - at_);
  at_ = end == std::string_view::npos ? text_.size() : end + 1;
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

std::filesystem::path beside(const std::filesystem::path& header, std::string_view name) {
  return header.parent_path() / std::filesystem::path(std::string(name));
}

Result<void> read_voxels(std::span<const std::byte> bytes, const DataBlock& block, StoredVolume& stored,
                         const Context& context) {
  if (block.encoding == DataEncoding::ascii) return read_ascii(bytes, block, stored, context);
  if (block.encoding == DataEncoding::raw) return read_raw(bytes, block, stored);
  if (block.skip < 0) {
    return bad_file(block.path, "asks to skip to the end of compressed data", "Export the file again");
  }
  const std::uint64_t needed = voxel_count(stored.size) * scalar_bytes(block.format.type);
  const auto skip = static_cast<std::uint64_t>(block.skip);
  // Deflate packs at most 1032 bytes into one.
  if ((needed + skip) / 1040 > bytes.size()) return too_short(block, stored);
  const Inflated plain = inflate_bytes(bytes, needed + skip, Deflate::gzip_or_zlib, &context);
  TURGOR_CHECK(context.check());
  if (plain.bytes.size() < needed + skip && plain.damaged) {
    return bad_file(block.path, "its compressed voxels are damaged or cut short",
                    "Copy or export the file again");
  }
  DataBlock inner = block;
  inner.encoding = DataEncoding::raw;
  return read_raw(plain.bytes, inner, stored);
}

}  // namespace turgor::scan_io
