#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <nlohmann/json.hpp>

#include "subcommands.hpp"
#include "terminal.hpp"
#include "turgor/anatomy/phantom.hpp"
#include "turgor/core/file.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/geometry/mesh_edit.hpp"
#include "turgor/geometry/mesh_file.hpp"
#include "turgor/imaging/isosurface.hpp"
#include "turgor/imaging/scan.hpp"

namespace turgor {
namespace {

PhantomParameters parameters_of(const Invocation& arguments) {
  PhantomParameters p;
  p.size = arguments.number("size");
  p.jaw_protrusion_mm = arguments.number("jaw_protrusion");
  p.thickness = arguments.number("thickness");
  p.voxel_mm = arguments.number("voxel");
  p.slice_mm = arguments.number("slice");
  p.noise_hu = arguments.number("noise");
  p.blur_mm = arguments.number("blur");
  p.seed = static_cast<std::uint64_t>(arguments.integer("seed"));
  p.head_holder = !arguments.flag("no_holder");
  p.condyles_touch = arguments.flag("condyles_touch");
  return p;
}

// The two centres that the exact thickness is measured towards: amid the midface and amid the lower jaw.
struct Centres {
  Vec3 upper, lower;
  double lip_level_mm;
};

Centres centres_of(const Phantom& phantom) {
  const auto& l = phantom.landmarks();
  const Vec3 back{0, 40 * phantom.parameters().size, 0};
  return {l.at("ans") + back, l.at("b_point") + back, l.at("stomion").z};
}

// Down the gradient of the exact skin's distance, until the point lies on it.
Vec3 put_on_skin(const Phantom& phantom, Vec3 p) {
  constexpr double h = 0.05;
  for (int step = 0; step < 4; ++step) {
    const double d = phantom.skin(p);
    if (std::abs(d) < 1e-9) break;
    Vec3 g{};
    for (int a = 0; a < 3; ++a) {
      Vec3 e{};
      e[a] = h;
      g[a] = (phantom.skin(p + e) - phantom.skin(p - e)) / (2 * h);
    }
    if (squared_length(g) > 1e-6) p -= g * (d / squared_length(g));
  }
  return p;
}

// Points of the exact skin: those of the scan's iso-surface, moved onto it.
Result<TriMesh> exact_skin(const Phantom& phantom, const CtVolume& scan, Context& context) {
  const Stage stage(context, "exact thickness");
  constexpr int triangles = 60'000;
  const TriMesh whole = isosurface(scan, -480.0);
  TURGOR_CHECK(context.check());
  TriMesh skin = decimate(whole, triangles);
  std::vector<std::uint8_t> on_skin(skin.points.size());
  std::atomic<std::size_t> done{0};
  // Small chunks: a point takes a fraction of a millisecond, and Ctrl-C waits for a chunk.
  parallel_for(skin.points.size(), 64, [&](std::size_t begin, std::size_t end) {
    if (context.cancelled()) return;
    for (std::size_t i = begin; i < end; ++i) {
      skin.points[i] = put_on_skin(phantom, skin.points[i]);
      on_skin[i] = std::abs(phantom.skin(skin.points[i])) < 0.01;
    }
    done += end - begin;
    context.progress(static_cast<double>(done) / static_cast<double>(skin.points.size()));
  });
  TURGOR_CHECK(context.check());
  // Inner walls of nostrils, mouth and head holder are not skin: what does not reach it is dropped.
  std::vector<bool> keep(skin.triangles.size());
  for (std::size_t t = 0; t < keep.size(); ++t) {
    keep[t] = true;
    for (const int p : skin.triangles[t]) keep[t] = keep[t] && on_skin[static_cast<std::size_t>(p)] != 0;
  }
  return submesh(skin, keep);
}

Result<void> write_thickness(const Phantom& phantom, const CtVolume& scan, const std::filesystem::path& path,
                             Context& context) {
  TURGOR_TRY(const TriMesh skin, exact_skin(phantom, scan, context));
  const Centres centres = centres_of(phantom);
  std::vector<Vec3> targets;
  for (const Vec3& p : skin.points)
    targets.push_back(p.z >= centres.lip_level_mm ? centres.upper : centres.lower);
  TURGOR_TRY(const std::vector<double> exact, phantom.thickness_map(skin.points, targets, context));
  MeshField field{"thickness_mm", 1, {}};
  for (const double t : exact) field.values.push_back(std::isfinite(t) ? static_cast<float>(t) : -1.0f);
  return write_ply(path, skin, {field});
}

std::string truth_json(const Phantom& phantom) {
  using Json = nlohmann::ordered_json;
  const auto triple = [](const Vec3& v) { return Json::array({v.x, v.y, v.z}); };
  const PhantomParameters& p = phantom.parameters();
  const Centres centres = centres_of(phantom);
  Json landmarks = Json::object();
  for (const auto& [name, point] : phantom.landmarks()) landmarks[name] = triple(point);
  const Json out{{"turgor", program_version},
                 {"parameters",
                  {{"size", p.size},
                   {"jaw_protrusion_mm", p.jaw_protrusion_mm},
                   {"thickness", p.thickness},
                   {"voxel_mm", p.voxel_mm},
                   {"slice_mm", p.slice_mm},
                   {"noise_hu", p.noise_hu},
                   {"blur_mm", p.blur_mm},
                   {"seed", p.seed},
                   {"head_holder", p.head_holder},
                   {"condyles_touch", p.condyles_touch}}},
                 {"thickness_towards",
                  {{"upper_centre_mm", triple(centres.upper)},
                   {"lower_centre_mm", triple(centres.lower)},
                   {"lip_level_mm", centres.lip_level_mm},
                   {"no_bone", -1}}},
                 {"landmarks_mm_lps", landmarks}};
  return out.dump(2) + "\n";
}

Result<void> write_phantom(const Phantom& phantom, const CtVolume& scan, const LabelVolume& labels,
                           const std::filesystem::path& folder, Context& context) {
  std::error_code code;
  if (std::filesystem::create_directory(folder / "dicom", code); code) {
    return Error{ErrorKind::system, "the folder cannot be made (" + code.message() + ")",
                 (folder / "dicom").string(), "Choose another output folder"};
  }
  DicomWriteOptions dicom;
  dicom.seed = phantom.parameters().seed;
  TURGOR_CHECK(write_dicom_series(folder / "dicom", scan, dicom, context));
  TURGOR_CHECK(write_nrrd(folder / "labels.nrrd", labels));
  TURGOR_CHECK(write_thickness(phantom, scan, folder / "thickness.ply", context));
  TURGOR_CHECK(context.check());
  return write_file(folder / "truth.json", truth_json(phantom));
}

}  // namespace

Result<void> run_phantom(const Invocation& arguments, Context& context) {
  const std::filesystem::path folder = arguments.path("output");
  TURGOR_CHECK(check_output_folder(folder));
  auto made = [&] {
    const StopAtOnce stop_at_once;  // shaping the phantom takes a second or two and asks nobody
    return Phantom::create(parameters_of(arguments));
  }();
  TURGOR_TRY(const Phantom phantom, std::move(made));
  TURGOR_TRY(const CtVolume scan, phantom.scan(context));
  TURGOR_TRY(const LabelVolume labels, phantom.labels(scan.grid, context));
  TURGOR_CHECK(write_folder(
      folder, [&](const auto& path) { return write_phantom(phantom, scan, labels, path, context); }));
  fmt::print("{} slices: {}\n", scan.grid.size[2], (folder / "dicom").string());
  return {};
}

}  // namespace turgor
