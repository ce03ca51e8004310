// What a scene's tissue and primitives refuse; who asked adds the place. Internal to the scene.
#pragma once

#include <string>
#include <utility>

#include "turgor/core/error.hpp"

namespace turgor {

inline Error bad_input(std::string what, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), {}, std::move(remedy)};
}

}  // namespace turgor
