#include "turgor/render/case_pictures.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "turgor/core/parallel.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/render/annotate.hpp"
#include "turgor/render/ray_tracer.hpp"

namespace turgor {
namespace {

struct View {
  StandardView view;
  const char* name;
  const char* words;
};
constexpr std::array<View, 4> face_views{
    {{StandardView::front, "front", "from the front"},
     {StandardView::profile_right, "profile", "right profile"},
     {StandardView::three_quarter_right, "three_quarter_right", "three-quarter view from the right"},
     {StandardView::three_quarter_left, "three_quarter_left", "three-quarter view from the left"}}};
constexpr std::size_t front_and_profile = 2;

constexpr Vec3f ghost_colour{0.10f, 0.25f, 0.75f};

// All pictures of a case share one frame, so that they can be laid over one another.
Box3 frame_box(const PatientCase& patient) {
  Box3 box = bounds(patient.head().skin);
  // The face, not the back of the head, fills the picture.
  const double depth = box.size().y;
  box.upper.y = box.lower.y + std::min(depth, 0.92 * depth);
  return box;
}

Body skin_body(const TriMesh& mesh) {
  return {&mesh, {MaterialKind::skin}, {}};
}

// Bones and teeth after the plan's moves (or before it).
struct Bones {
  std::vector<TriMesh> meshes;
  std::vector<bool> moved;
};

Bones bones_of(const PatientCase& patient, bool after) {
  Bones bones;
  for (const BoneSegment& s : patient.bones().segments()) {
    if (s.surface.empty()) continue;
    TriMesh mesh = after ? transformed(s.surface, s.motion) : s.surface;
    double shift = 0;
    for (std::size_t i = 0; i < mesh.points.size(); i += 97) {
      shift = std::max(shift, distance(s.motion.point(s.surface.points[i]), s.surface.points[i]));
    }
    bones.moved.push_back(shift > 1e-6);
    bones.meshes.push_back(std::move(mesh));
  }
  return bones;
}

std::vector<Body> bone_bodies(const Bones& bones, bool mark_moved) {
  std::vector<Body> bodies;
  for (std::size_t i = 0; i < bones.meshes.size(); ++i) {
    Body body{&bones.meshes[i], {MaterialKind::bone}, {}};
    if (mark_moved && bones.moved[i])
      body.point_colours.assign(bones.meshes[i].points.size(), {0.35f, 0.60f, 0.62f});
    bodies.push_back(std::move(body));
  }
  return bodies;
}

std::vector<Vec3f> coloured(const std::vector<float>& values, double highest) {
  std::vector<Vec3f> colours(values.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    colours[i] = light_colour_map(static_cast<double>(values[i]) / highest);
  return colours;
}

// The next of 1, 2, 3, 4, 5, 6, 8, 10 … millimetres above the greatest value: a legend that reads well.
double legend_top(double greatest) {
  for (const double top :
       {1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0, 75.0}) {
    if (greatest <= top) return top;
  }
  return greatest;
}

class Studio {
 public:
  Studio(const PatientCase& patient, const PictureOptions& options, Context& context)
      : box_(frame_box(patient)), context_(context) {
    render_.width = options.width;
    render_.height = options.height;
    render_.samples = options.samples;
  }

  // `bodies` from every view of the face, each annotated by `draw`.
  template <class Draw>
  Result<void> shoot(const std::vector<Body>& bodies, const std::string& name, const std::string& what,
                     Draw&& draw, std::size_t views = face_views.size()) {
    TURGOR_TRY(const Renderer renderer, Renderer::create(bodies, context_));
    for (std::size_t v = 0; v < views; ++v) {
      TURGOR_CHECK(context_.check());
      const CameraView camera = standard_view(face_views[v].view, box_);
      TURGOR_TRY(Image image, renderer.render(camera, render_, context_));
      draw_orientation(image, camera);
      draw(image, camera);
      pictures_.push_back({name + "_" + face_views[v].name, what + ", " + face_views[v].words, {}});
      images_.push_back(std::move(image));
    }
    return {};
  }
  Result<void> shoot(const std::vector<Body>& bodies, const std::string& name, const std::string& what,
                     std::size_t views = face_views.size()) {
    return shoot(
        bodies, name, what, [](Image&, const CameraView&) {}, views);
  }
  // Packing takes as long as rendering, so it is done for all pictures at once.
  std::vector<Picture> take() {
    parallel_for(images_.size(), 1,
                 [&](std::size_t begin, std::size_t) { pictures_[begin].png = encode_png(images_[begin]); });
    images_.clear();
    return std::move(pictures_);
  }

 private:
  Box3 box_;
  Context& context_;
  RenderOptions render_;
  std::vector<Picture> pictures_;
  std::vector<Image> images_;
};

std::vector<Marker> markers(const PatientCase& patient, bool on_bone) {
  std::vector<Marker> out;
  for (const auto& [name, landmark] : patient.landmarks()) {
    const LandmarkKind* kind = find_landmark_kind(name);
    if (kind == nullptr || kind->on_bone != on_bone) continue;
    const Vec3f colour = landmark.corrected ? Vec3f{0.05f, 0.35f, 0.8f} : Vec3f{0.8f, 0.05f, 0.05f};
    out.push_back({landmark.point, std::string(kind->label), colour});
  }
  return out;
}

// Thickness of the tissue on its skin; columns that met no bone in grey.
std::vector<Vec3f> thickness_colours(const LayeredTissue& tissue, double highest) {
  std::vector<Vec3f> colours;
  for (std::size_t c = 0; c < tissue.thickness_mm.size(); ++c) {
    const bool met = tissue.ends[c] != ColumnEnd::none;
    colours.push_back(met ? colour_map(tissue.thickness_mm[c] / highest) : Vec3f{0.42f, 0.42f, 0.42f});
  }
  return colours;
}

}  // namespace

Result<std::vector<Picture>> prediction_pictures(const PatientCase& patient, const Prediction& prediction,
                                                 const PictureOptions& options, Context& context) {
  const Stage stage(context, "pictures");
  Studio studio(patient, options, context);
  const Bones before = bones_of(patient, false), after = bones_of(patient, true);
  const auto face = [](const TriMesh& skin, const Bones& bones) {
    std::vector<Body> bodies = bone_bodies(bones, false);  // seen through the open mouth
    bodies.push_back(skin_body(skin));
    return bodies;
  };
  TURGOR_CHECK(studio.shoot(face(patient.skin(), before), "before", "Before surgery"));
  TURGOR_CHECK(studio.shoot(face(prediction.skin, after), "after", "Predicted face after surgery"));
  std::vector<Body> both = face(prediction.skin, after);
  both.push_back({&patient.skin(), {MaterialKind::plain, ghost_colour, 0.3, true}, {}});
  TURGOR_CHECK(studio.shoot(both, "superimposed", "After surgery, with the face before in blue"));
  const double top =
      legend_top(*std::max_element(prediction.displacement_mm.begin(), prediction.displacement_mm.end()));
  const Body map{&prediction.skin, {MaterialKind::plain}, coloured(prediction.displacement_mm, top)};
  TURGOR_CHECK(studio.shoot(
      {map}, "displacement", "Movement of the skin in millimetres",
      [&](Image& image, const CameraView&) { draw_legend(image, 0, top, "mm", light_colour_map); }));
  TURGOR_CHECK(studio.shoot(bone_bodies(after, true), "bones_after",
                            "Bones after surgery, moved segments in green", front_and_profile));
  return studio.take();
}

Result<std::vector<Picture>> model_pictures(const PatientCase& patient, const PictureOptions& options,
                                            Context& context) {
  const Stage stage(context, "pictures of the model");
  Studio studio(patient, options, context);
  const auto annotate = [&](bool on_bone) {
    return [&patient, on_bone](Image& image, const CameraView& camera) {
      draw_markers(image, camera, markers(patient, on_bone));
      draw_scale_bar(image, camera);
    };
  };
  const Bones bones = bones_of(patient, false);
  std::vector<Body> bodies = bone_bodies(bones, false);
  const TriMesh& cut = patient.head().mandible_cut;
  if (!cut.empty()) bodies.push_back({&cut, {MaterialKind::plain, {0.8f, 0.1f, 0.1f}, 1.0}, {}});
  TURGOR_CHECK(studio.shoot(bodies, "bones",
                            cut.empty() ? "Bones" : "Bones; where the mandible was cut free in red",
                            annotate(true), front_and_profile));
  TURGOR_CHECK(studio.shoot({skin_body(patient.head().skin)}, "landmarks", "Landmarks on the skin",
                            annotate(false), front_and_profile));
  const LayeredTissue& tissue = patient.tissue();
  const double top = legend_top(*std::max_element(tissue.thickness_mm.begin(), tissue.thickness_mm.end()));
  const Body thickness{&tissue.surface, {MaterialKind::plain}, thickness_colours(tissue, top)};
  TURGOR_CHECK(studio.shoot(
      {thickness}, "thickness", "Thickness of the soft tissue in millimetres; grey: no bone under it",
      [&](Image& image, const CameraView&) { draw_legend(image, 0, top, "mm"); }, front_and_profile));
  return studio.take();
}

}  // namespace turgor
