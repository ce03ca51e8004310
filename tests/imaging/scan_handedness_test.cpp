// A mirrored patient is the worst error that a planner can make: one bright voxel at a known patient point is
// found there after reading, for every format, array order, handedness and obliqueness.
#include "imaging/scan_format_files.hpp"

namespace turgor {
namespace {
using namespace scan_test;

bool left_handed(const std::array<Vec3, 3>& axes) {
  return dot(axes[0], cross(axes[1], axes[2])) < 0;
}

/// Writes the marked volume on each kind of axes with `write(path, lattice, voxels)` and reads it back.
template <class Write>
void expect_mark_on_all_axes(const std::string& name, Write&& write, double tolerance_mm = 1e-3) {
  const Scratch scratch;
  for (const auto& axes : all_axes()) {
    const Lattice lattice = lattice_with_mark(axes);
    SCOPED_TRACE(vector_text(axes[0]) + vector_text(axes[1]) + vector_text(axes[2]));
    write(scratch / name, lattice, marked_voxels(lattice.size));
    const auto scan = read(scratch / name);
    ASSERT_TRUE(scan) << scan.error().message();
    expect_mark(*scan, tolerance_mm);
    EXPECT_EQ(scan->info.stored_left_handed, left_handed(axes));
  }
}

TEST(Handedness, NrrdInLpsFindsTheMark) {
  expect_mark_on_all_axes("a.nrrd", [](const auto& path, const Lattice& l, const auto& voxels) {
    write_text(path, nrrd_header(l) + "\n" + bytes_of(voxels));
  });
}

TEST(Handedness, NrrdInRasFindsTheMark) {
  expect_mark_on_all_axes("a.nrrd", [](const auto& path, const Lattice& l, const auto& voxels) {
    write_text(path, nrrd_header(l, "right-anterior-superior", {-1, -1, 1}) + "\n" + bytes_of(voxels));
  });
}

TEST(Handedness, NrrdInLasFindsTheMark) {
  expect_mark_on_all_axes("a.nrrd", [](const auto& path, const Lattice& l, const auto& voxels) {
    write_text(path, nrrd_header(l, "LAS", {1, -1, 1}) + "\n" + bytes_of(voxels));
  });
}

TEST(Handedness, NiftiSformFindsTheMark) {
  expect_mark_on_all_axes("a.nii", [](const auto& path, const Lattice& l, const auto& voxels) {
    write_text(path, nifti_header(l) + bytes_of(voxels));
  });
}

TEST(Handedness, NiftiQformFindsTheMark) {
  // Near a half turn the format's 32-bit quaternion is good to some micrometres only.
  expect_mark_on_all_axes(
      "a.nii.gz",
      [](const auto& path, const Lattice& l, const auto& voxels) {
        NiftiSpec spec;
        spec.use_qform = true;
        write_text(path, gzip(nifti_header(l, spec) + bytes_of(voxels)));
      },
      0.02);
}

TEST(Handedness, MetaImageFindsTheMark) {
  expect_mark_on_all_axes("a.mha", [](const auto& path, const Lattice& l, const auto& voxels) {
    write_text(path, meta_header(l) + bytes_of(voxels));
  });
}

TEST(Handedness, InvesaliusRowsRunFromBackToFront) {
  const Scratch scratch;
  const Vec3 spacing{0.8, 1.1, 2.5};
  const Index3 size{9, 11, 7};
  write_text(scratch / "a.inv3",
             inv3_file(inv3_plist(size, spacing), bytes_of(marked_voxels(size, {2, 7, 4}))));
  const auto scan = read(scratch / "a.inv3");
  ASSERT_TRUE(scan) << scan.error().message();
  EXPECT_TRUE(scan->info.stored_left_handed);
  // Stored row 7 from the back is canonical row 3 from the front; y runs to the back.
  EXPECT_EQ(scan->hu.at(2, 3, 4), kMarkHu);
  const Vec3 place = scan->hu.grid.to_patient({2, 3, 4});
  EXPECT_LT(distance(place, Vec3{2 * 0.8, -7 * 1.1, 4 * 2.5}), 1e-9);
  EXPECT_EQ(scan->hu.grid.direction.c, Mat3{}.c);
}

TEST(Handedness, EveryFormatGivesTheSameScan) {
  const Scratch scratch;
  const auto axes = all_axes()[37];
  const Lattice l = lattice_with_mark(axes);
  const auto voxels = marked_voxels(l.size);
  write_text(scratch / "a.nrrd", nrrd_header(l) + "\n" + bytes_of(voxels));
  write_text(scratch / "a.mha", meta_header(l) + bytes_of(voxels));
  write_text(scratch / "a.nii", nifti_header(l) + bytes_of(voxels));
  const auto nrrd = read(scratch / "a.nrrd"), meta = read(scratch / "a.mha"), nifti = read(scratch / "a.nii");
  ASSERT_TRUE(nrrd && meta && nifti);
  expect_same(nrrd->hu, meta->hu);
  expect_same(nrrd->hu, nifti->hu, 1e-4);
}

TEST(Handedness, NrrdRoundTripIsExact) {
  const Scratch scratch;
  const CtVolume volume = busy_volume();
  ASSERT_TRUE(write_nrrd(scratch / "a.nrrd", volume));
  const auto scan = read(scratch / "a.nrrd");
  ASSERT_TRUE(scan) << scan.error().message();
  expect_same(scan->hu, volume, 1e-9);
  EXPECT_FALSE(scan->info.stored_left_handed);
}

TEST(Handedness, WarnsWhereTheFileDoesNotTellLeftFromRight) {
  const Scratch scratch;
  const Lattice l = lattice_with_mark({Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}});
  std::string nrrd = nrrd_header(l);
  nrrd.replace(nrrd.find("space: left-posterior-superior"), 30, "space dimension: 3");
  write_text(scratch / "a.nrrd", nrrd + "\n" + bytes_of(marked_voxels(l.size)));
  std::string meta = meta_header(l);
  meta.erase(meta.find("TransformMatrix"), meta.find("Offset") - meta.find("TransformMatrix"));
  write_text(scratch / "a.mha", meta + bytes_of(marked_voxels(l.size)));
  std::string nifti = nifti_header(l);
  nifti[254] = 0;
  write_text(scratch / "a.nii", nifti + bytes_of(marked_voxels(l.size)));
  for (const char* name : {"a.nrrd", "a.mha", "a.nii"}) {
    Context context;
    ASSERT_TRUE(read_scan(scratch / name, {}, context));
    bool warned = false;
    for (const Notice& notice : context.notices()) {
      warned = warned || (notice.severity == Severity::warning &&
                          notice.text.find("left and right are not certain") != std::string::npos);
    }
    EXPECT_TRUE(warned) << name;
  }
}

TEST(Handedness, WarnsWhereSformAndQformDisagree) {
  const Scratch scratch;
  const Lattice l = lattice_with_mark({Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}});
  NiftiSpec spec;
  spec.use_qform = true;
  std::string header = nifti_header(l, spec);
  const std::string with_sform = nifti_header(l);
  header.replace(254, 2, with_sform.substr(254, 2));
  header.replace(280, 48, with_sform.substr(280, 48));
  const auto warnings = [&] {
    write_text(scratch / "a.nii", header + bytes_of(marked_voxels(l.size)));
    Context context;
    EXPECT_TRUE(read_scan(scratch / "a.nii", {}, context));
    int count = 0;
    for (const Notice& n : context.notices()) count += n.text.find("disagree") != std::string::npos ? 1 : 0;
    return count;
  };
  EXPECT_EQ(warnings(), 0);
  const float mirrored = -1;
  std::memcpy(header.data() + 76, &mirrored, sizeof mirrored);
  EXPECT_EQ(warnings(), 1);
}

}  // namespace
}  // namespace turgor
