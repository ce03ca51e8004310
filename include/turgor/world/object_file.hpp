// Objects from files, and the primitives that need none.
//
// An object file (.object) is text: one keyword and its values a line, ';' or '#' starts a comment. In place
// of the thesis's .obj/.asc/.det/.dm (Pieper 1989, section 4.2). docs/object-files.md lists the keywords.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/world/object.hpp"

namespace turgor {

/// A shape by name: grid.N.M and wiregrid.N.M (1 × 1 about the origin, N × M points, point = N row + column,
/// rows along y), sphere (radius ½), cube (edge 1), line, fusiform (1 × 1 with a spindle-shaped hole;
/// 174 points), gear (diameter 1 about the z axis), phantom_skin and phantom_bone (the built-in head, mm).
/// Errors: no such primitive, too many points.
Result<Object> make_primitive(const std::string& name);
/// The names as they are typed, for help and completion.
std::vector<std::string> primitive_names();

struct ObjectSource {
  std::vector<std::filesystem::path> search_paths;  ///< looked through in order, before our own library
};
/// Finds and reads what a script names: the file itself; on the search paths (a relative path whole, an
/// absolute one by its last part, with a notice); then our own library: object files and primitives, with or
/// without an extension, with a notice where a path was given. The object is named as the last part of
/// `name` without extension (that of grid.10.10 is none). Errors: none of these exists (names the nearest
/// primitive); a damaged file, by line.
Result<Object> load_object(const std::string& name, const ObjectSource& source, Context& context);

Result<Object> parse_object(std::string_view text, const std::string& file_name);
/// Text that parses to the same object.
std::string object_text(const Object& object);

/// Text of a view or other script of our own library ("lookat_wound"); nullptr where there is none.
const std::string* library_script(const std::string& name);

}  // namespace turgor
