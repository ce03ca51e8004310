// turgor mesh: of surfaces and of parts of scans, into every format.
#include <filesystem>
#include <string>

#include "program/phantom_program.hpp"

namespace {
using namespace turgor_program;

/// A tetrahedron of 9 mm as OFF, without its last `missing` faces.
std::string tetrahedron_off(int missing) {
  std::string text = "OFF\n4 " + std::to_string(4 - missing) + " 0\n0 0 0\n9 0 0\n0 9 0\n0 0 9\n";
  const char* const faces[] = {"3 0 2 1\n", "3 0 1 3\n", "3 0 3 2\n", "3 1 2 3\n"};
  for (int f = 0; f < 4 - missing; ++f) text += faces[f];
  return text;
}

TEST_F(Program, MeshesASurfaceIntoEveryFormat) {
  const fs::path surface = root() / "corner.off";
  write(surface, tetrahedron_off(0));
  const std::string mesh = "mesh " + surface.string() + " -resolution 12 -o " + root().string();
  for (const char* name : {"/c.ele", "/c.vtu", "/c.msh", "/c.inp", "/c.solid"}) {
    const Outcome o = run(mesh + name);
    EXPECT_EQ(o.code, 0) << o.text;
    EXPECT_NE(o.text.find(" tetrahedra, "), std::string::npos) << o.text;
    EXPECT_TRUE(fs::exists(root().string() + name));
  }
  EXPECT_TRUE(fs::exists(root() / "c.node") && fs::exists(root() / "c.face"));
  const Outcome cubes = run(mesh + "/cubes.inp -hexahedra -no_border");
  EXPECT_NE(cubes.text.find(" hexahedra, "), std::string::npos) << cubes.text;
  EXPECT_NE(bytes_of(root() / "cubes.inp").find("C3D8"), std::string::npos);
}

TEST_F(Program, SurfacesThatCannotBeMeshedAreRefused) {
  const fs::path open = root() / "open.off";
  write(open, tetrahedron_off(1));
  const std::string mesh = "mesh " + open.string() + " -o " + out().string();
  expect_refusal(mesh + ".vtu", "hole of 9 x 9 x 9 mm");
  expect_refusal(mesh + ".stl", "not written to files of this kind");
  expect_refusal(mesh + ".ele -hexahedra", "tetrahedra only");
  expect_refusal(mesh + ".vtu -resolution 0", "resolution");
  expect_refusal("mesh " + (root() / "no.off").string() + " -o " + out().string() + ".vtu", "no.off");
  const std::string picture = (root() / "leak.png").string();
  expect_refusal(mesh + ".vtu -leak_picture " + picture, "leak.png shows where");
  EXPECT_EQ(bytes_of(picture).substr(1, 3), "PNG");
  expect_refusal(mesh + ".vtu -spacing 2", "-spacing is for parts of a scan");
  expect_refusal(mesh + ".vtu -fine 0 0 0 1 1 1", "-fine is for graded solids");
  EXPECT_EQ(run(mesh + ".vtu -fill winding").code, 0);
  fs::remove(out().string() + ".vtu");
}

TEST_F(Program, MeshesPartsOfScansAndGradesSolids) {
  // A label map of 12 x 12 x 12 voxels of 2 mm: label 3 within the inner 8 x 8 x 8.
  const fs::path labels = root() / "labels.nrrd";
  std::string voxels;
  const auto inner = [](int n) { return n >= 2 && n < 10; };
  for (int k = 0; k < 12; ++k)
    for (int j = 0; j < 12; ++j)
      for (int i = 0; i < 12; ++i) voxels += inner(i) && inner(j) && inner(k) ? '\3' : '\0';
  write(labels,
        "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 12 12 12\n"
        "space directions: (2,0,0) (0,2,0) (0,0,2)\nspace origin: (0,0,0)\nencoding: raw\n\n" +
            voxels);
  const std::string mesh = "mesh " + labels.string() + " -o " + (root() / "l.vtu").string();
  const Outcome own = run(mesh + " -label 3");
  EXPECT_EQ(own.code, 0) << own.text;
  EXPECT_NE(own.text.find("2560 tetrahedra"), std::string::npos) << own.text;
  EXPECT_NE(own.text.find("cubes of 2 mm"), std::string::npos) << own.text;
  const Outcome graded = run(mesh + " -label 3 -resolution 32 -graded 2 -fine 10 10 10 12 12 12");
  EXPECT_EQ(graded.code, 0) << graded.text;
  EXPECT_NE(graded.text.find("dihedral angles 45 to"), std::string::npos) << graded.text;
  EXPECT_NE(run(mesh + " -above 2 -spacing 1").text.find("cubes of 1 mm"), std::string::npos);
  expect_refusal(mesh + " -label 4", "Give labels that there are: 3");
  expect_refusal(mesh + " -above 100", "no voxel lies within the threshold");
  expect_refusal(mesh + " -label 3 -no_border", "-no_border is for surfaces");
  expect_refusal(mesh + " -label 3 -above 2", "label");
}

}  // namespace
