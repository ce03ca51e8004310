// Viewports and worlds as data: what is shown where (Pieper 1989, section 4.2).
#pragma once

#include <string>
#include <vector>

#include "turgor/math/vec.hpp"

namespace turgor {

enum class DrawStyle { shaded, wire };

/// A rectangle of the screen, in fractions of its width and height from the lower left corner.
struct Viewport {
  std::string name;
  double left = 0, bottom = 0, right = 1, top = 1;
  std::string camera;  ///< name of a camera object
  std::string world;   ///< name of a world
  DrawStyle style = DrawStyle::shaded;
  bool stereo = false;           ///< red for the left eye, green for the right one
  double eye_separation = 0.03;  ///< of stereo, as a fraction of the distance to the target
  bool title = false;            ///< a bar with its name
  bool border = false;
  bool visible = true;
};

/// A named list of objects, by name.
struct World {
  std::string name;
  std::vector<std::string> objects;
};

/// Viewports are drawn in order: later ones cover earlier ones.
struct Screen {
  int width = 960, height = 720;  ///< pixels
  Vec3f background{1, 1, 1};      ///< linear RGB
  std::vector<Viewport> viewports;
};

}  // namespace turgor
