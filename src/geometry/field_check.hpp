// Whether fields fit the mesh they are to be written with. Internal to the module.
#pragma once

#include <cctype>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor::detail {

/// Error where the surface breaks its own rules: nothing is written then.
inline Result<void> check_surface(const TriMesh& mesh, const std::filesystem::path& path) {
  const Result<void> valid = validate(mesh);
  if (valid) return {};
  return Error{ErrorKind::internal, valid.error().what, path.string()};
}

/// Error where a field has not `components` values for each of `count` points or cells.
inline Result<void> check_fields(const std::vector<MeshField>& fields, std::size_t count,
                                 const std::filesystem::path& path) {
  for (const MeshField& field : fields) {
    if (field.components > 0 && field.values.size() == count * static_cast<std::size_t>(field.components))
      continue;
    return Error{ErrorKind::internal,
                 "field \"" + field.name + "\" has " + std::to_string(field.values.size()) + " values for " +
                     std::to_string(count) + " places of " + std::to_string(field.components),
                 path.string()};
  }
  return {};
}

/// The name with everything but letters, digits, '_', '-' and '.' replaced, safe in any header.
inline std::string safe_name(const std::string& name) {
  std::string safe = name.empty() ? "field" : name;
  for (char& c : safe) {
    const bool plain = (std::isalnum(static_cast<unsigned char>(c)) != 0) || c == '_' || c == '-' || c == '.';
    if (!plain) c = '_';
  }
  return safe;
}

}  // namespace turgor::detail
