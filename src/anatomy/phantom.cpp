#include "turgor/anatomy/phantom.hpp"

#include <fmt/format.h>

#include "anatomy/phantom_pose.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {

using phantom::Part;

struct Phantom::Shapes {
  phantom::PosedParts parts;
  std::map<std::string, Vec3> landmarks;
  explicit Shapes(const PhantomParameters& parameters)
      : parts(parameters), landmarks(phantom::true_landmarks(parts)) {}
};

namespace {

Result<void> check_range(const char* name, double value, double low, double high) {
  // Written so that NaN fails too.
  if (value >= low && value <= high) return {};
  return Error{ErrorKind::bad_input,
               fmt::format("the phantom's {} is {} but must lie between {} and {}", name, value, low, high),
               "", fmt::format("Choose a {} from {} to {}", name, low, high)};
}

Result<void> check(const PhantomParameters& p) {
  TURGOR_CHECK(check_range("size", p.size, 0.7, 1.3));
  TURGOR_CHECK(check_range("jaw protrusion in mm", p.jaw_protrusion_mm, -12, 12));
  TURGOR_CHECK(check_range("thickness", p.thickness, 0.6, 1.6));
  TURGOR_CHECK(check_range("voxel size in mm", p.voxel_mm, 0.4, 3));
  TURGOR_CHECK(check_range("slice spacing in mm", p.slice_mm, 0.4, 5));
  TURGOR_CHECK(check_range("noise in HU", p.noise_hu, 0, 100));
  TURGOR_CHECK(check_range("blur in mm", p.blur_mm, 0, 2));
  return {};
}

}  // namespace

Result<Phantom> Phantom::create(const PhantomParameters& parameters) {
  TURGOR_CHECK(turgor::check(parameters));
  return Phantom(std::make_unique<const Shapes>(parameters));
}

Phantom::Phantom(std::unique_ptr<const Shapes> shapes) : shapes_(std::move(shapes)) {}
Phantom::~Phantom() = default;
Phantom::Phantom(Phantom&&) noexcept = default;

const PhantomParameters& Phantom::parameters() const {
  return shapes_->parts.parameters();
}
double Phantom::skin(const Vec3& p) const {
  return shapes_->parts.distance(Part::skin, p);
}
double Phantom::skull(const Vec3& p) const {
  return shapes_->parts.distance(Part::skull, p);
}
double Phantom::mandible(const Vec3& p) const {
  return shapes_->parts.distance(Part::mandible, p);
}
const std::map<std::string, Vec3>& Phantom::landmarks() const {
  return shapes_->landmarks;
}
Box3 Phantom::extent() const {
  return phantom::scan_extent(parameters());
}

PhantomLabel Phantom::label(const Vec3& p) const {
  phantom::TissueProbe probe(shapes_->parts, p);
  int layer = 0;
  while (probe.outline(layer) >= 0) ++layer;  // the last layer is everywhere
  return probe.label(layer);
}

double Phantom::hounsfield(const Vec3& p) const {
  phantom::TissueProbe probe(shapes_->parts, p);
  int layer = 0;
  while (probe.outline(layer) >= 0) ++layer;
  return phantom::TissueProbe::layers[static_cast<std::size_t>(layer)].hounsfield;
}

std::optional<double> Phantom::trace(PhantomSurface surface, const Vec3& origin, const Vec3& direction,
                                     double max_mm) const {
  return phantom::trace(shapes_->parts, surface, origin, direction, max_mm);
}

Result<std::vector<double>> Phantom::thickness_map(std::span<const Vec3> points,
                                                   std::span<const Vec3> targets, Context& context) const {
  if (targets.size() != 1 && targets.size() != points.size()) {
    return Error{
        ErrorKind::bad_input,
        fmt::format("a thickness map of {} points was given {} targets", points.size(), targets.size()), "",
        "Give one target for all points, or one for each"};
  }
  const Stage stage(context, "Measuring the phantom's soft tissue");
  std::vector<double> thickness(points.size());
  parallel_for(points.size(), 256, [&](std::size_t begin, std::size_t end) {
    if (context.cancelled()) return;
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 to = targets[targets.size() == 1 ? 0 : i] - points[i];
      const auto hit = trace(PhantomSurface::bone, points[i], normalized(to), length(to));
      thickness[i] = hit.value_or(std::numeric_limits<double>::quiet_NaN());
    }
  });
  TURGOR_CHECK(context.check());
  return thickness;
}

Result<CtVolume> Phantom::scan(Context& context) const {
  return phantom::scan(shapes_->parts, context);
}
Result<LabelVolume> Phantom::labels(const Grid& grid, Context& context) const {
  return phantom::labels(shapes_->parts, grid, context);
}

}  // namespace turgor
