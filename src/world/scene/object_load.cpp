// Finding what a script names.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>

#include "turgor/core/file.hpp"
#include "turgor/geometry/mesh_file.hpp"
#include "turgor/world/object_file.hpp"
#include "world/scene/library.hpp"
#include "world/scene/name.hpp"

namespace turgor {
namespace fs = std::filesystem;
namespace {

Result<Object> read_object(const fs::path& path) {
  if (!is_surface_file(path)) {
    TURGOR_TRY(const std::string text, read_text_file(path, std::uint64_t{1} << 30));
    return parse_object(text, path.string());
  }
  TURGOR_TRY(const TriMesh mesh, read_mesh(path));
  Object object;
  object.file = path.string();
  object.description = to_polyhedron(mesh);
  return object;
}

bool is_file(const fs::path& path) {
  std::error_code code;
  return fs::is_regular_file(path, code);
}

/// The file itself, then where the search paths have it.
std::optional<fs::path> find_file(const fs::path& path, const ObjectSource& source) {
  if (is_file(path)) return path;
  for (const fs::path& folder : source.search_paths) {
    fs::path candidate = folder / (path.is_absolute() ? path.filename() : path);
    if (is_file(candidate)) return candidate;
  }
  return std::nullopt;
}

/// What our own library has under the last part of a path; nothing where it has none.
std::optional<Result<Object>> from_library(const std::string& last) {
  if (const std::string* const text = library_object(last)) {
    auto object = parse_object(*text, last);
    if (object) object->file.clear();
    return object;
  }
  const std::string stem = object_name(last);
  if (is_primitive_name(stem)) return make_primitive(stem);
  return std::nullopt;
}

Error nothing_found(const std::string& name, const std::string& last, const ObjectSource& source) {
  std::string remedy = "Correct the path";
  if (const std::string_view nearest = nearest_primitive(last); !nearest.empty()) {
    remedy = fmt::format("Did you mean the primitive {}?", nearest);
  } else if (!source.search_paths.empty()) {
    remedy += ", or the search paths";
  }
  return {ErrorKind::bad_input,
          fmt::format("no object file and no primitive {}", shown_name(name)),
          {},
          std::move(remedy)};
}

}  // namespace

std::string object_name(const std::string& path) {
  const fs::path last = fs::path(path).filename();
  const std::string extension = last.extension().string();
  // grid.10.10 has none.
  const bool numbered = extension.size() > 1 && std::isdigit(static_cast<unsigned char>(extension[1])) != 0;
  return numbered ? last.string() : last.stem().string();
}

Result<Object> load_object(const std::string& name, const ObjectSource& source, Context& context) {
  const fs::path path(name);
  const std::string last = path.filename().string();
  if (last.empty() || name.find('\0') != std::string::npos) {
    return Error{ErrorKind::bad_input,
                 fmt::format("{} names no object", shown_name(name)),
                 {},
                 "Name a file or a primitive"};
  }
  if (const auto file = find_file(path, source)) {
    if (path.is_absolute() && *file != path) {
      context.notice(fmt::format("{} is not there; {} is read in its place", name, file->string()));
    }
    TURGOR_TRY(Object object, read_object(*file));
    object.name = object_name(name);
    return object;
  }
  auto object = from_library(last);
  if (!object) return nothing_found(name, last, source);
  if (!*object) return object->error();
  if (path.has_parent_path()) {
    context.notice(fmt::format("{} is not there; {} of Turgor's own library stands in for it", name, last));
  }
  return *std::move(*object);
}

}  // namespace turgor
