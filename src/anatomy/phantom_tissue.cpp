#include "anatomy/phantom_shapes.hpp"

namespace turgor::phantom {

using implicit::ellipsoid;
using implicit::Side;
using implicit::sweep;

Field air_spaces() {
  Field f;
  f.join(sweep({{{7.4, -106, -32}, 2.8},
                {{7.3, -103.5, -24}, 3.0},
                {{5.8, -97, -15}, 3.6},
                {{5.5, -86, -13}, 4.2},
                {{5.5, -60, -14}, 4},
                {{5.5, -36, -14}, 5}}),
         0, Side::sharp);
  f.join(sweep({{{4, -86, -2}, 2.2}, {{4, -64, 4}, 2.4}, {{4.5, -44, 2}, 2.4}}), 4, Side::sharp);
  f.join(sweep({{{0, -26, -14}, 9},
                {{0, -17, -38}, 7},
                {{0, -14, -75}, 7},
                {{0, -20, -105}, 6},
                {{0, -23, -130}, 8.5},
                {{0, -20, -200}, 8.5}}),
         4);
  f.join(ellipsoid({25, -65, -17.5}, {7.7, 9.2, 10.2}), 1, Side::both);
  f.join(sweep({{{78, 3, 3}, 3.2}, {{44, 2, 3}, 2.8}}), 1, Side::both);
  f.join(implicit::rounded_box({0, -93.5, -46.9}, {24.5, 19.5, 0.6}, 0.6), 0.5);
  f.join(ellipsoid({0, -60, -40.5}, {17, 21, 6}), 2);
  f.join(sweep({{{0, -42, -40}, 3}, {{0, -20, -44}, 4}}), 3);
  return f;
}

Field muscles() {
  Field f;
  f.join(ellipsoid({50, -30, -36}, {8, 17, 30}), 3, Side::both);  // masseter
  f.join(ellipsoid({54, -26, 30}, {12, 36, 40}), 3, Side::both);  // temporalis
  // Orbicularis oris, upper and lower half.
  f.join(bow({{{0, -97, -40}, 5}, {{12, -93, -40}, 5}, {{24, -84, -46}, 5}}), 3);
  f.join(bow({{{0, -93, -56}, 5}, {{12, -90, -55}, 5}, {{24, -83, -48}, 5}}), 3);
  f.join(ellipsoid({0, -52, -56}, {20, 30, 15}), 3);                         // tongue
  f.join(sweep({{{36, -70, -40}, 3}, {{37, -45, -42}, 4}}), 3, Side::both);  // buccinator
  f.join(sweep({{{30, -30, -12}, 9}, {{42, -24, -50}, 6}}), 3, Side::both);  // pterygoids
  f.join(sweep({{{0, 16, -40}, 44}, {{0, 16, -110}, 46}, {{0, 16, -200}, 50}}), 6);
  f.join(sweep({{{0, -20, -40}, 16}, {{0, -20, -200}, 18}}), 6);
  f.join(sweep({{{52, 22, -28}, 8}, {{38, -8, -90}, 9}, {{16, -36, -165}, 7}, {{12, -40, -200}, 7}}), 4,
         Side::both);
  return f;
}

Field cartilage() {
  Field f;
  f.join(implicit::rounded_box({0, -97, -9}, {0.9, 9, 11}, 0.8, rotation({1, 0, 0}, radians(-25))));
  f.join(sweep({{{3, -112, -14}, 1.2}, {{10, -104, -14}, 1.1}, {{13.5, -97, -17}, 1.1}}), 1, Side::both);
  return f;
}

Field head_holder() {
  Field f;
  // Two plates, parts of a wide trough beside and behind the head.
  f.join(implicit::wall({{96, 30, 60, 85, 2},
                         {93, 62, 60, 85, 2},
                         {80, 92, 60, 85, 2},
                         {58, 112, 60, 85, 2},
                         {30, 122, 60, 85, 2}},
                        0.9),
         0, Side::sharp);
  return f;
}

}  // namespace turgor::phantom
