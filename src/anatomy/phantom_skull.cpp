#include "anatomy/phantom_shapes.hpp"

namespace turgor::phantom {

using implicit::ellipsoid;
using implicit::group;
using implicit::offset;
using implicit::rounded_box;
using implicit::Side;
using implicit::sweep;

ShapePtr cranium() {
  Field f;
  f.join(ellipsoid({0, 2, 49}, {69, 88, 73}));
  f.join(ellipsoid({0, -38, 52}, {54, 50, 52}), 14);
  f.join(ellipsoid({0, 50, 30}, {56, 42, 48}), 14);
  f.join(ellipsoid({30, 22, 56}, {40, 50, 50}), 16, Side::both);
  f.join(ellipsoid({42, -2, 34}, {27, 46, 34}), 14, Side::both);
  f.join(ellipsoid({0, 45, -2}, {50, 38, 34}), 14);
  return group(std::move(f));
}

ShapePtr brain_space() {
  Field f;
  f.join(implicit::half_space(Plane{{0, 0, -1}, -38}));
  f.join(ellipsoid({34, -12, 31}, {25, 27, 22}), 8, Side::both);
  f.join(ellipsoid({0, 44, 8}, {45, 40, 36}), 8);
  f.keep(offset(cranium(), -6), 6);
  return group(std::move(f));
}

ShapePtr condyle(double grown_by) {
  const Vec3 r = condyle_radii + Vec3{grown_by, grown_by, grown_by};
  return ellipsoid(condyle_centre, r, rotation({0, 0, 1}, radians(-15)));
}

namespace {

// Middle of the vertebral bodies: a gentle forward bend.
double spine_depth(double z) {
  return 9 + 0.0005 * (z + 44) * (z + 170);
}

void join_orbital_rims(Field& f) {
  f.join(
      sweep({{{3, -83.5, 34}, 7}, {{20, -83, 37}, 6.5}, {{39.5, -75.5, 35}, 5.5}, {{48.8, -65.5, 25}, 4.5}}),
      9, Side::both);
  f.join(sweep({{{48.3, -65, 26}, 4.3}, {{48.6, -62.5, 11}, 3.6}, {{48, -66.5, -4}, 4.5}}), 6, Side::both);
  f.join(
      sweep({{{48.5, -67, -4}, 4.5}, {{40, -74, -9}, 4.5}, {{27, -78.5, -7.5}, 4.5}, {{16.5, -81, 1}, 3.5}}),
      7, Side::both);
  f.join(sweep({{{16, -80.5, 1}, 3.5}, {{12.5, -82, 12}, 3.5}, {{9.5, -83, 27}, 5}}), 6, Side::both);
}

void join_midface(Field& f) {
  // Nasal bones, the frontal processes beside them, the rim of the piriform opening.
  f.join(sweep({{{1.5, -83.2, 27}, 4.6}, {{1.7, -88.3, 15}, 4.2}, {{2.2, -96.8, 4.5}, 3.3}}), 5, Side::both);
  f.join(sweep({{{7.5, -82.5, 22}, 3.6},
                {{9, -86.3, 5}, 2.8},
                {{13, -84.5, -8}, 3.5},
                {{13.5, -83.5, -18}, 3.5},
                {{9, -82.5, -25}, 3.5},
                {{2, -81.5, -27.5}, 3.8}}),
         6, Side::both);
  // Maxilla with its alveolar process and canine eminence, palate, anterior nasal spine.
  f.join(ellipsoid({24, -68, -21}, {15, 13, 20}), 8, Side::both);
  f.join(bow_wall({{0, -84.5, -34, 5, 4},
                   {8, -83, -34, 5, 4},
                   {15, -77.5, -33, 6, 4.4},
                   {19.5, -70, -32, 6.5, 5},
                   {23.5, -60, -31.5, 6.8, 5.5},
                   {26.5, -46, -31, 6.8, 5.2}},
                  0.9),
         7);
  for (ShapePtr& socket : upper_sockets()) f.join(std::move(socket), 3.5, Side::both);
  f.join(ellipsoid({0, -60, -28.5}, {23, 23, 3.2}), 4);
  f.join(sweep({{{0, -77, -27}, 4}, {{0, -84, -25.8}, 2.4}, {{0, -88.6, -25}, 1.3}}), 4);
}

void join_cheekbones(Field& f) {
  const Mat3 turned = rotation({0, 0, 1}, radians(35));
  f.join(ellipsoid({43, -66.5, -10}, {13, 8, 12}, turned), 8, Side::both);
  f.join(sweep({{{49, -63, -9}, 6},
                {{57, -50, -6}, 4.3},
                {{60.5, -36, -3}, 3.6},
                {{60.5, -20, 1}, 3.8},
                {{57, -4, 5}, 6}}),
         5, Side::both);
  f.join(sweep({{{42, -66, -15}, 7}, {{33, -62, -28}, 6}, {{28, -60, -35}, 5}}), 6, Side::both);
}

void join_base(Field& f) {
  // Walls of the orbits, sphenoid, pterygoid plates, mastoids, articular eminences.
  f.join(ellipsoid({9.5, -67, 12}, {3.5, 15, 14}), 4, Side::both);
  f.join(sweep({{{29.5, -61, 15}, 19.5}, {{22, -48, 15}, 15}, {{15, -34, 15}, 10}}), 5, Side::both);
  f.join(ellipsoid({0, -18, -2}, {17, 28, 18}), 8);
  f.join(sweep({{{14, -32, -8}, 5}, {{13, -38, -22}, 3.5}, {{14, -40, -35}, 3}}), 5, Side::both);
  f.join(ellipsoid({50, 21, -8}, {8, 11, 18}), 16, Side::both);
  f.join(sweep({{{42, -22, 2}, 5}, {{58, -20, 3}, 4.5}}), 6, Side::both);
}

void join_spine(Field& f) {
  // Occipital condyles and the joints below them keep the column in one piece with the skull.
  std::vector<implicit::Knot> pillar{{{15, 16, -30}, 5}};
  for (int i = 0; i < 9; ++i) {
    const double z = -44.0 - 17 * i, y = spine_depth(z);
    pillar.push_back({{19.5, y + 11, z + 5}, 5});
    pillar.push_back({{18, y + 12, z - 4}, 4.2});
  }
  f.join(sweep(pillar, 2), 4, Side::both);
  for (int i = 0; i < 8; ++i) {
    const double z = -44.0 - 17 * i, y = spine_depth(z);
    f.join(rounded_box({0, y, z}, {12.5, 9, 7.2}, 5.5), 3);
    f.join(sweep({{{9, y + 5, z}, 4},
                  {{18, y + 11, z}, 4.5},
                  {{10, y + 25, z - 3}, 3.5},
                  {{0, y + 31, z - 5}, 3.5}},
                 3),
           3, Side::both);
    f.join(sweep({{{0, y + 30, z - 5}, 3.4}, {{0, y + (i == 0 ? 33 : 45), z - 11}, 3}}, 1), 4);
  }
}

void cut_cavities(Field& f, const Fit& fit) {
  f.cut(brain_space(), 1);
  // Orbits: four cones to the apex make the rounded square of the opening.
  Field orbit;
  for (const Vec3& corner : {Vec3{26, -92, 19}, Vec3{38, -88, 19.5}, Vec3{40, -88, 8}, Vec3{26, -92, 9}}) {
    orbit.join(sweep({{corner, 12.4}, {{16, -36, 15}, 4}}, 1), 10);
  }
  f.cut(group(std::move(orbit)), 2.5, Side::both);
  // Nasal cavity behind its pear-shaped opening, maxillary sinuses.
  Field nose;
  nose.join(sweep({{{5.2, -100, -15.5}, 6.6}, {{5.2, -70, -14}, 6}, {{5.5, -38, -14}, 6}}), 0, Side::both);
  nose.join(sweep({{{1.5, -100, -2}, 3.4}, {{2, -70, 6}, 5}, {{3, -42, 4}, 5}}), 10, Side::both);
  f.cut(group(std::move(nose)), 2);
  f.cut(ellipsoid({25, -65, -17.5}, {8.5, 10, 11}), 2, Side::both);
  f.join(rounded_box({0, -58, -6}, {0.9, 18, 17}, 0.8), 1.5);  // septum
  f.cut(condyle(fit.joint_gap), 1, Side::both);
  f.cut(sweep({{{75, 3, 3}, 3.6}, {{42, 2, 3}, 3.2}}), 2, Side::both);
  f.cut(sweep({{{0, 20, -12}, 11}, {{0, 24, -50}, 9}, {{0, 27, -110}, 8.5}, {{0, 30, -190}, 8.5}}), 2);
}

}  // namespace

Field skull_bone(const Fit& fit) {
  Field f;
  f.join(cranium());
  join_base(f);
  join_orbital_rims(f);
  join_midface(f);
  join_cheekbones(f);
  join_spine(f);
  cut_cavities(f, fit);
  return f;
}

}  // namespace turgor::phantom
