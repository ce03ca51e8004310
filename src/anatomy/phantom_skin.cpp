#include "anatomy/phantom_shapes.hpp"

namespace turgor::phantom {

using implicit::ellipsoid;
using implicit::group;
using implicit::offset;
using implicit::Side;
using implicit::sweep;

namespace {

void join_face(Field& f) {
  f.join(ellipsoid({0, -50, -8}, {57, 38, 52}), 22);
  f.join(ellipsoid({32, -64.5, -14}, {27, 23, 22}), 18, Side::both);  // cheeks
  f.join(sweep({{{49, -52, -3}, 15}, {{56, -27, 0}, 14}, {{54, 0, 2}, 14}}), 24,
         Side::both);                                  // over the arch
  f.join(ellipsoid({0, -66, -44}, {37, 34, 28}), 18);  // muzzle
  f.join(sweep({{{42, -16, -57}, 13.5}, {{37, -40, -66}, 14}, {{26, -65, -77}, 13}, {{8, -82, -83}, 13}}), 18,
         Side::both);                                               // jaw line
  f.join(ellipsoid({42, -26, -34}, {19, 30, 36}), 26, Side::both);  // masseter
  f.join(ellipsoid({32, -58, -40}, {26, 27, 30}), 22, Side::both);  // buccal
  f.join(ellipsoid({0, -83, -82}, {18, 16, 15}), 12);               // chin
  f.join(ellipsoid({0, -46, -66}, {42, 38, 24}), 18);               // floor of mouth
  f.join(sweep({{{3, -84, 34}, 9},
                {{24, -83.5, 38}, 9},
                {{44, -74, 35}, 8},
                {{53, -60, 22}, 8},
                {{56, -46, 8}, 8}}),
         18, Side::both);
  f.join(ellipsoid({46, -42, 22}, {16, 30, 28}), 20, Side::both);  // temple, filled by its muscle
}

void join_neck(Field& f) {
  f.join(sweep({{{0, 16, -10}, 46}, {{0, 15, -90}, 44}, {{0, 16, -130}, 47}, {{0, 22, -200}, 62}}), 34);
  f.join(sweep({{{47, 22, -10}, 14}, {{35, -4, -85}, 11.5}, {{18, -34, -150}, 12}, {{12, -40, -190}, 12}}),
         26, Side::both);
  f.join(sweep({{{8, -24, -88}, 15}, {{8, -27, -120}, 16}, {{6, -27, -190}, 17}}), 24, Side::both);
  f.join(ellipsoid({0, -38, -122}, {9, 8, 12}), 12);
}

void join_eyes(Field& f) {
  f.cut(ellipsoid({30, -97.5, 12}, {17, 12.5, 12.5}), 12, Side::both);
  f.join(ellipsoid(eye_centre + Vec3{0, 0.3, -0.5}, {14.5, 14, 13.5}), 5, Side::both);
  f.join(ellipsoid({45.5, -65, 15.5}, {8, 9.5, 13}), 9, Side::both);  // over the lateral rim
  // The crease over the upper lid, and the line where the closed lids meet.
  f.cut(sweep({{{19, -84.5, 15.5}, 0.3},
               {{24, -85.3, 20}, 0.8},
               {{31.5, -86, 21.5}, 1.0},
               {{40, -82.5, 20}, 0.9},
               {{47, -76, 14.5}, 0.6}}),
        2.5, Side::both);
  f.cut(sweep({{{16.5, -85, 11.5}, 0.3},
               {{23.5, -85.2, 9}, 0.8},
               {{31.5, -86.8, 8}, 0.8},
               {{39.5, -84.3, 9}, 0.8},
               {{47, -77.5, 11.5}, 0.4}}),
        1.5, Side::both);
}

void join_nose(Field& f) {
  f.join(sweep({{{0, -84, 26}, 7.5}, {{0, -93.5, 9}, 7.3}, {{0, -101, -3}, 8}, {{0, -106, -12.5}, 10.5}}),
         10);
  // Its sides slope into the cheeks.
  f.join(sweep({{{7, -82.5, 14}, 9}, {{10, -86.5, -6}, 9}, {{11, -91, -16}, 9}}), 14, Side::both);
  f.join(sweep({{{3.5, -87, 14}, 6}, {{5, -93, -1}, 6.2}, {{5.5, -98, -11}, 6.8}}), 8, Side::both);
  f.join(ellipsoid({12, -98, -18}, {6.3, 10, 7.5}), 3.5, Side::both);
  f.join(sweep({{{0, -111, -19}, 5}, {{0, -101, -23.5}, 5}}), 5);
  f.cut(ellipsoid({7.6, -103.5, -27}, {3.2, 6, 4.5}, rotation({0, 0, 1}, radians(20))), 2.5, Side::both);
}

void join_lips(Field& f) {
  f.join(bow({{{0, -94.3, -31}, 7}, {{12, -91.3, -33}, 7.5}, {{26, -81, -42}, 8}}), 14);
  f.cut(sweep({{{0, -106, -27}, 2.2}, {{0, -108.5, -37}, 2.4}}), 6);
  // Upper lip with its bow, lower lip, the furrow between them, the fold above the chin.
  f.join(bow({{{0, -99.7, -42.3}, 5},
              {{6, -99.4, -41.7}, 5},
              {{14.5, -95.6, -43.4}, 4.3},
              {{24.5, -88.5, -46.5}, 2.5}}),
         6);
  f.join(bow({{{0, -97, -53}, 5.8},
              {{8, -96.1, -52.5}, 5.4},
              {{16.5, -92.2, -50.6}, 4},
              {{24.5, -88, -48}, 2.5}}),
         6);
  f.cut(bow({{{0, -103.7, -47.3}, 1.0},
             {{8, -102.8, -46.7}, 1.0},
             {{17.5, -98, -46.9}, 0.9},
             {{25.5, -92.9, -47.6}, 0.3}}),
        3);
  f.join(bow({{{0, -85.5, -66}, 10}, {{14, -81, -65}, 10}, {{26, -70, -60}, 11}}), 10);
}

// The auricle in its own frame: u backwards, v up, w outwards, the tragus near the origin.
ShapePtr ear() {
  Field f;
  f.join(implicit::plate({0, 0, 0}, {},
                         {{-2, 18},
                          {4, 27},
                          {14, 31},
                          {24, 27},
                          {29, 15},
                          {27, 2},
                          {20, -10},
                          {12, -22},
                          {4, -30},
                          {-3, -27},
                          {-5, -14},
                          {-4, 2}},
                         1.6, 1.5));
  f.join(ellipsoid({7, 2, -6}, {11, 21, 7}), 6);
  f.join(sweep({{{6, 3, 1}, 1.8},
                {{-1, 10, 2}, 2.2},
                {{0, 21, 3}, 2.5},
                {{7, 29, 3.5}, 2.7},
                {{16, 31, 4}, 2.8},
                {{25, 26, 4.5}, 2.8},
                {{29.5, 14, 4}, 2.7},
                {{27.5, 1, 3}, 2.5},
                {{21, -10, 2}, 2.3},
                {{13, -20, 1.5}, 2.2}}),
         2);
  f.join(sweep({{{12, 21, 1.5}, 1.8},
                {{18, 12, 2.5}, 2.3},
                {{18.5, 0, 3}, 2.4},
                {{13, -10, 2.5}, 2.3},
                {{7, -14, 2.5}, 2.4}}),
         3);
  f.join(ellipsoid({3, -24, 1}, {6.5, 8, 3}), 4);
  f.cut(ellipsoid({8, -1, 2}, {6.5, 9, 5.5}), 3);
  f.join(ellipsoid({-1.5, -3, 2}, {3, 5.5, 3.5}), 2.5);
  return group(std::move(f));
}

}  // namespace

Field skin() {
  Field f;
  f.join(offset(cranium(), 6));
  join_face(f);
  join_neck(f);
  join_eyes(f);
  join_nose(f);
  join_lips(f);
  const Mat3 frame = rotation({0, 0, 1}, radians(-22)) * rotation({1, 0, 0}, radians(-14)) *
                     rotation({0, 1, 0}, radians(8)) * Mat3{{Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{1, 0, 0}}};
  f.join(implicit::moved(ear(), {frame, {69.5, 1, 4}}), 5, Side::both);
  return f;
}

}  // namespace turgor::phantom
