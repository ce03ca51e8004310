// Names of objects, worlds and primitives. Internal to the scene.
#pragma once

#include <string>
#include <string_view>

#include "turgor/core/error.hpp"

namespace turgor {

/// Errors: empty, or something that a script could not type as one plain word.
Result<void> check_name(std::string_view name);
/// In quotes, safe to print, long ones cut short.
std::string shown_name(std::string_view name);

/// The last part of a path without its extension.
std::string object_name(const std::string& path);

/// Whether make_primitive knows the name, whatever the numbers in it.
bool is_primitive_name(std::string_view name);
/// As it is typed; empty where none is near.
std::string_view nearest_primitive(std::string_view name);

}  // namespace turgor
