#include <archive.h>
#include <archive_entry.h>
#include <fmt/format.h>

#include <map>
#include <memory>
#include <optional>
#include <pugixml.hpp>
#include <string_view>

#include "imaging/scan/readers.hpp"
#include "imaging/scan/scalars.hpp"

namespace turgor::scan_io {
namespace {

constexpr const char* kExportAgain = "Save the project again in InVesalius, or copy the file again";

/// What the property list says about the array.
struct ProjectHeader {
  std::string matrix_file;
  Index3 size{1, 1, 1};
  Vec3 spacing{1, 1, 1};
  ScalarType type = ScalarType::int16;
  std::string name, modality;
};

/// The value element that follows `<key>name</key>` in a property-list dictionary.
pugi::xml_node plist_value(const pugi::xml_node& dict, std::string_view name) {
  for (const pugi::xml_node& key : dict.children("key")) {
    if (name == key.child_value()) return key.next_sibling();
  }
  return {};
}

/// Three numbers of a property-list array.
std::optional<Vec3> plist_triple(const pugi::xml_node& array) {
  Vec3 values;
  int n = 0;
  for (const pugi::xml_node& item : array.children()) {
    if (n < 3) values[n] = item.text().as_double();
    ++n;
  }
  return n == 3 ? std::optional(values) : std::nullopt;
}

std::optional<ScalarType> numpy_type(std::string_view name) {
  static const std::map<std::string_view, ScalarType> types{
      {"uint8", ScalarType::uint8},     {"int8", ScalarType::int8},       {"uint16", ScalarType::uint16},
      {"int16", ScalarType::int16},     {"uint32", ScalarType::uint32},   {"int32", ScalarType::int32},
      {"float32", ScalarType::float32}, {"float64", ScalarType::float64}, {"int64", ScalarType::int64}};
  const auto found = types.find(name);
  return found == types.end() ? std::nullopt : std::optional(found->second);
}

Result<ProjectHeader> parse_plist(const std::vector<char>& text, const std::filesystem::path& path) {
  pugi::xml_document document;
  if (!document.load_buffer(text.data(), text.size())) {
    return bad_file(path, "its main.plist is damaged", kExportAgain);
  }
  const pugi::xml_node root = document.child("plist").child("dict");
  const pugi::xml_node matrix = plist_value(root, "matrix");
  const auto shape = plist_triple(plist_value(matrix, "shape"));
  const auto spacing = plist_triple(plist_value(root, "spacing"));
  const auto type = numpy_type(plist_value(matrix, "dtype").child_value());
  ProjectHeader header;
  header.matrix_file = plist_value(matrix, "filename").child_value();
  if (!shape || !spacing || !type || header.matrix_file.empty()) {
    return bad_file(path, "its main.plist lacks the name, shape, type or spacing of the array", kExportAgain);
  }
  for (const int a : {0, 1, 2}) {
    if (!((*shape)[a] >= 1 && (*shape)[a] <= 1e9)) {
      return bad_file(path, "the shape in its main.plist is not usable", kExportAgain);
    }
  }
  // The shape is stored as numpy has it: slices, rows, columns.
  TURGOR_TRY(header.size,
             checked_size({static_cast<std::int64_t>(shape->z), static_cast<std::int64_t>(shape->y),
                           static_cast<std::int64_t>(shape->x)},
                          path));
  header.spacing = *spacing;
  header.type = *type;
  header.name = plist_value(root, "name").child_value();
  header.modality = plist_value(root, "modality").child_value();
  return header;
}

struct ArchiveCloser {
  void operator()(archive* a) const { archive_read_free(a); }
};
using Archive = std::unique_ptr<archive, ArchiveCloser>;

Result<Archive> open_archive(const SourceFile& file) {
  Archive reader(archive_read_new());
  archive_read_support_format_tar(reader.get());
  archive_read_support_filter_gzip(reader.get());
  if (archive_read_open_memory(reader.get(), file.bytes.data(), file.bytes.size()) != ARCHIVE_OK) {
    return bad_file(file.path, "is not an InVesalius project (a gzip-compressed tar archive)", kExportAgain);
  }
  return reader;
}

/// The present entry's bytes, at most `limit`; memory grows with what is really there, not with what is
/// claimed.
std::optional<std::vector<char>> read_entry(archive* reader, std::size_t limit, Context& context) {
  std::vector<char> bytes;
  const void* block = nullptr;
  std::size_t size = 0;
  la_int64_t offset = 0;
  for (;;) {
    const int status = archive_read_data_block(reader, &block, &size, &offset);
    if (status == ARCHIVE_EOF) return bytes;
    if (status != ARCHIVE_OK && status != ARCHIVE_WARN) return std::nullopt;
    if (context.cancelled() || static_cast<std::size_t>(offset) != bytes.size() ||
        bytes.size() + size > limit) {
      return std::nullopt;
    }
    const char* from = static_cast<const char*>(block);
    bytes.insert(bytes.end(), from, from + size);
  }
}

/// Calls `visit(base name, archive)` for each entry until it returns true. False at the end of a whole
/// archive.
template <class Visit>
Result<bool> walk(const SourceFile& file, Visit&& visit) {
  TURGOR_TRY(const Archive reader, open_archive(file));
  archive_entry* entry = nullptr;
  for (;;) {
    const int status = archive_read_next_header(reader.get(), &entry);
    if (status == ARCHIVE_EOF) return false;
    if (status != ARCHIVE_OK && status != ARCHIVE_WARN) {
      return bad_file(file.path, "is damaged or cut short", kExportAgain);
    }
    const char* name = archive_entry_pathname(entry);
    if (name == nullptr) continue;
    TURGOR_TRY(const bool stop, visit(std::filesystem::path(name).filename().string(), reader.get()));
    if (stop) return true;
  }
}

}  // namespace

Result<StoredVolume> read_inv3(const SourceFile& file, Context& context) {
  std::optional<ProjectHeader> header;
  std::optional<std::vector<char>> matrix;
  const auto visit = [&](const std::string& name, archive* reader) -> Result<bool> {
    if (!header && name == "main.plist") {
      const auto text = read_entry(reader, 16 << 20, context);
      if (!text) return bad_file(file.path, "its main.plist is cut short", kExportAgain);
      TURGOR_TRY(header, parse_plist(*text, file.path));
    } else if (header && !matrix && name == header->matrix_file) {
      matrix = read_entry(reader, voxel_count(header->size) * scalar_bytes(header->type), context);
      TURGOR_CHECK(context.check());
      if (!matrix) {
        return bad_file(file.path, fmt::format("its {} is damaged or longer than its shape", name),
                        kExportAgain);
      }
    }
    return header && matrix;
  };
  // The property list comes first in practice; where it does not, the array is found in a second walk.
  TURGOR_TRY(bool found, walk(file, visit));
  if (!found && header) {
    TURGOR_TRY(found, walk(file, visit));
  }
  if (!header)
    return bad_file(file.path, "holds no main.plist, so it is not an InVesalius project", kExportAgain);
  if (!found) return bad_file(file.path, fmt::format("holds no {}", header->matrix_file), kExportAgain);
  if (matrix->size() != voxel_count(header->size) * scalar_bytes(header->type)) {
    return bad_file(file.path, fmt::format("its {} is shorter than its shape", header->matrix_file),
                    kExportAgain);
  }
  StoredVolume stored;
  stored.size = header->size;
  stored.axes = {Vec3{header->spacing.x, 0, 0}, Vec3{0, -header->spacing.y, 0},
                 Vec3{0, 0, header->spacing.z}};
  stored.voxels.resize(voxel_count(header->size));
  stored.losses = to_hounsfield(std::as_bytes(std::span(*matrix)), {header->type}, stored.voxels);
  stored.info.format = "InVesalius";
  stored.info.patient = header->name;
  stored.info.modality = header->modality;
  return stored;
}

}  // namespace turgor::scan_io
