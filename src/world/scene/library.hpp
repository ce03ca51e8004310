// Object files of our own library. Internal to the scene.
#pragma once

#include <string>
#include <string_view>

namespace turgor {

/// Text of an object file ("sphere.obj"); nullptr where there is none.
const std::string* library_object(std::string_view name);

}  // namespace turgor
