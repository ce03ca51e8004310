// Our own library: what the thesis's scripts name and nobody has kept.
#include "world/scene/library.hpp"

#include <filesystem>
#include <map>

#include "turgor/world/object_file.hpp"

namespace turgor {
namespace {

using Texts = std::map<std::string, std::string, std::less<>>;

const Texts& object_files() {
  static const Texts files{
      {"sphere.obj",
       R"(; The ball of the drape test (Pieper 1989, section 6.1.2): between the tissue at z = 0 and
; the floor at z = -0.25, which it reaches through.
name sphere
shape sphere
scale 0.4 0.4 0.4
translate 0 0 -0.2
diffuse 0.20 0.34 0.52
line_width 0.5
)"},
  };
  return files;
}

const Texts& scripts() {
  static const Texts files{
      {"lookat_wound",
       R"(; The wound closure test: the sheet from the front, the right and above, so that the opening
; and the dog-ears at both of its ends show. The light comes in low from the left, for what rises.
camera camera -eye 0.62 -2.05 1.22 -look_at -0.04 0 0.0 -fov 26
light key -from -1.5 -0.3 0.75 -strength 1.3
light fill -from 1 -1 1 -strength 0.15
screen -background 0.80 0.85 0.90
)"},
      {"lookat.balldrape",
       R"(; The drape test: tissue, ball and floor, from so low that one sees under the tissue; and the same
; from the side in lines, for what the skin hides.
camera camera -eye 0.95 -2.75 0.50 -look_at 0.02 0 -0.035 -fov 25
light key -from -1.1 -0.9 1.3
light fill -from 1 -1 0.5 -strength 0.15
screen -background 0.80 0.85 0.90
camera side -eye 0 -9 -0.02 -look_at 0 0 -0.02 -height 0.72
viewport side -at 0.66 0.77 1 1 -camera side -style wire -border
)"},
      {"lockat-twitch",
       R"(; The muscle test: the tissue, tilted, as it falls on the floor at z = -0.45; and the same from
; above in lines, for the muscle that the skin hides.
camera camera -eye 1.25 -2.6 0.75 -look_at 0 0 -0.16 -fov 27
light key -from -0.9 -0.7 1.3
light fill -from 1 -1 0.5 -strength 0.15
screen -background 0.80 0.85 0.90
camera above -eye 0 0 9 -look_at 0 0 0 -up 0 1 0 -height 1.2
viewport above -at 0.74 0 1 0.347 -camera above -style wire -border
)"},
  };
  return files;
}

const std::string* find(const Texts& texts, std::string_view name) {
  const auto found = texts.find(name);
  return found == texts.end() ? nullptr : &found->second;
}

}  // namespace

const std::string* library_object(std::string_view name) {
  return find(object_files(), name);
}

const std::string* library_script(const std::string& name) {
  return find(scripts(), std::filesystem::path(name).filename().string());
}

}  // namespace turgor
