#include "anatomy/phantom_shapes.hpp"

namespace turgor::phantom {

using implicit::ellipsoid;
using implicit::plate;
using implicit::Side;
using implicit::sweep;

Field mandible_bone(const Fit& fit) {
  Field f;
  // Body: basal bone, and the alveolar process along the teeth.
  f.join(bow_wall({{0, -77.5, -76, 13.5, 5.8},
                   {10, -76.3, -76, 13.5, 5.8},
                   {20, -70, -74, 13, 5.6},
                   {28.5, -59, -71, 12.5, 5.4},
                   {35.5, -45, -67.5, 12.5, 5},
                   {42, -30, -62, 13, 4.5}},
                  0.9));
  f.join(bow_wall({{0, -82, -64.5, 4, 3.8},
                   {7, -80.8, -64.5, 4, 3.8},
                   {14, -77, -64, 4.5, 4},
                   {19, -70.5, -63, 5.5, 4.5},
                   {23, -60, -62.5, 7, 5},
                   {27, -46, -60, 7, 4.8}},
                  0.9),
         7);
  for (ShapePtr& socket : lower_sockets(fit)) f.join(std::move(socket), 3.5, Side::both);
  // Chin.
  f.join(ellipsoid({0, -79.5, -82}, {14, 8, 8}), 8);
  f.join(ellipsoid({12, -78, -86}, {7, 6, 4.5}), 6, Side::both);
  // Ramus with coronoid and condylar processes; it leans outwards to the top and to the back.
  const Mat3 axes = rotation({0, 0, 1}, radians(-8)) * rotation({0, 1, 0}, radians(6)) *
                    Mat3{{Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{1, 0, 0}}};
  f.join(plate({45.6, -26, -35}, axes,
               {{14, -23},
                {8, -32},
                {-6, -36},
                {-18, -28},
                {-17, -10},
                {-18, 5},
                {-19, 20},
                {-17, 31},
                {-12, 26},
                {-5, 17},
                {4, 19},
                {9, 29},
                {15, 33},
                {19, 27},
                {17, 10},
                {15, -8}},
               4.2, 3),
         5, Side::both);
  f.join(sweep({{{46, -13.5, -24}, 4.2}, {{48.5, -12.5, -7}, 4.3}}), 4, Side::both);
  f.join(condyle(0), 3, Side::both);
  f.join(sweep({{{42, -43, -38}, 3.6}, {{39.5, -46, -52}, 4}, {{32.5, -55, -64}, 4}}), 5, Side::both);
  return f;
}

}  // namespace turgor::phantom
