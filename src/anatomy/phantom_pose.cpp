#include "anatomy/phantom_pose.hpp"

namespace turgor::phantom {
namespace {

using implicit::smooth_step;

constexpr double cell_mm = 8;
// mm: trying a quadric on a box of a smaller radius costs as much as it saves.
constexpr double least_fitted = 2;
const Box3 indexed_box{{-112, -140, -192}, {112, 140, 144}};

// Depth and height over which the mandible's body grows: before it all moves with the chin, behind it nothing
// moves.
constexpr double body_front = -42, body_back = -10;

double gaussian(const Vec3& q, const Vec3& centre, double width) {
  const Vec3 d{std::abs(q.x) - centre.x, q.y - centre.y, q.z - centre.z};
  return std::exp(-squared_length(d) / (2 * width * width));
}

Fit fit_of(const PhantomParameters& parameters) {
  Fit fit;
  if (parameters.condyles_touch) {
    const double narrow = std::min(0.3, 0.4 * std::min(parameters.voxel_mm, parameters.slice_mm));
    fit.joint_gap = fit.occlusal_gap = narrow / parameters.size;
  }
  return fit;
}

Field with_teeth(Field bone, Field teeth) {
  bone.join(implicit::group(std::move(teeth)), 0.8);
  return bone;
}

}  // namespace

PosedParts::PosedParts(const PhantomParameters& parameters) : parameters_(parameters) {
  const Fit fit = fit_of(parameters);
  const auto put = [&](Part part, Field field) {
    fields_[static_cast<std::size_t>(part)] = implicit::IndexedField(std::move(field), indexed_box, cell_mm);
  };
  Field brain;
  brain.join(brain_space());
  put(Part::skin, skin());
  put(Part::skull, with_teeth(skull_bone(fit), upper_teeth(fit)));
  put(Part::mandible, with_teeth(mandible_bone(fit), lower_teeth(fit)));
  put(Part::upper_teeth, upper_teeth(fit));
  put(Part::lower_teeth, lower_teeth(fit));
  put(Part::air, air_spaces());
  put(Part::muscle, muscles());
  put(Part::brain, std::move(brain));
  put(Part::cartilage, cartilage());
  put(Part::holder, head_holder());
  // More than the steepest slope per mm of the shares below: of each step 1.875 over its width, of those that
  // overlap; and the widening beside the mouth.
  constexpr double bone_slope = 0.081, soft_slope = 0.114;
  const double shift =
      std::abs(parameters.jaw_protrusion_mm) / parameters.size * std::hypot(1, occlusal_slope);
  for (std::size_t i = 0; i < part_count; ++i) {
    switch (static_cast<Part>(i)) {
      case Part::mandible:
      case Part::lower_teeth:
        stretch_[i] = 1 + shift * bone_slope;
        break;
      case Part::skin:
      case Part::air:
      case Part::muscle:
      case Part::cartilage:
        stretch_[i] = 1 + shift * soft_slope;
        break;
      default:
        stretch_[i] = 1;
        break;
    }
  }
  thickening_slope_[static_cast<std::size_t>(Part::skin)] = 0.8 * std::abs(parameters.thickness - 1);
}

double PosedParts::lipschitz(Part part) const {
  const auto i = static_cast<std::size_t>(part);
  return fields_[i].lipschitz() * stretch_[i] + thickening_slope_[i];
}

double PosedParts::lipschitz(Part part, const Vec3& p, double radius) const {
  const auto i = static_cast<std::size_t>(part);
  return fields_[i].lipschitz(reference(part, p), reference_radius(part, radius)) * stretch_[i] +
         thickening_slope_[i];
}

double PosedParts::reference_radius(Part part, double radius) const {
  const double scale = part == Part::holder ? 1 : parameters_.size;
  return radius / scale * stretch_[static_cast<std::size_t>(part)];
}

double PosedParts::bone_share(const Vec3& q) const {
  return smooth_step(body_back, body_front, q.y) * smooth_step(-6, -40, q.z);
}

double PosedParts::soft_share(const Vec3& q) const {
  // The upper lip stays, the lower goes with the chin for the most part; beside the mouth the cheek is drawn
  // along over more of its height, without a ledge. Below the chin all fades into the neck.
  const double cheek = smooth_step(26, 46, std::abs(q.x));
  return smooth_step(body_back, body_front, q.y) * smooth_step(-39 + 20 * cheek, -60 - 6 * cheek, q.z) *
         smooth_step(-128, -98, q.z);
}

// Where a point lay before the jaw grew forward, along the occlusal plane.
Vec3 PosedParts::without_protrusion(const Vec3& q, double share) const {
  const double d = parameters_.jaw_protrusion_mm / parameters_.size * share;
  return {q.x, q.y + d, q.z + occlusal_slope * d};
}

// Soft tissue over the bone, mm: what a thickness of 1 stands for.
double PosedParts::thickening(const Vec3& q) const {
  double t = 5.5;
  t += 10 * gaussian(q, {38, -58, -38}, 17) + 5 * gaussian(q, {48, -22, -45}, 18) +
       2.5 * gaussian(q, {30, -80, -10}, 14);
  t += 5.5 * gaussian(q, {0, -104, -34}, 14) + 5 * gaussian(q, {0, -98, -70}, 14);
  t -= 2.5 * gaussian(q, {0, -104, 2}, 13) + 4.5 * gaussian(q, {0, -106, -17}, 13);
  t -= 3.5 * gaussian(q, {31, -88, 12}, 12);
  t -= 4.5 * gaussian(q, {0, -104, -47}, 7) + 4 * gaussian(q, {18, -98, -47}, 7);
  // The auricles keep their thickness.
  const double ear = squared_length(Vec3{std::abs(q.x) - 80, q.y - 14, q.z - 2}) / (40.0 * 40.0);
  return t * (1 - 0.95 * std::exp(-ear * ear));
}

Vec3 PosedParts::reference(Part part, const Vec3& p) const {
  if (part == Part::holder) return p;
  const Vec3 q = p / parameters_.size;
  if (parameters_.jaw_protrusion_mm == 0) return q;
  switch (part) {
    case Part::mandible:
    case Part::lower_teeth:
      return without_protrusion(q, bone_share(q));
    case Part::skin:
    case Part::air:
    case Part::muscle:
    case Part::cartilage:
      return without_protrusion(q, soft_share(q));
    default:
      return q;
  }
}

double PosedParts::posed(Part part, const Vec3& q, double value) const {
  if (part == Part::holder) return value;
  if (part == Part::skin && parameters_.thickness != 1) value -= (parameters_.thickness - 1) * thickening(q);
  return value * parameters_.size;
}

double PosedParts::value(Part part, const Vec3& p) const {
  const Vec3 q = reference(part, p);
  return posed(part, q, fields_[static_cast<std::size_t>(part)].value(q));
}

double PosedParts::value(Part part, const Vec3& p, const LocalFields& local) const {
  const auto i = static_cast<std::size_t>(part);
  if ((local.fitted >> i & 1) != 0) return local.quadrics[i].at(p);
  const Vec3 q = reference(part, p);
  return posed(part, q, (local.held >> i & 1) != 0 ? local.fields[i].value(q) : fields_[i].value(q));
}

void PosedParts::add_local(LocalFields& local, Part part, const Vec3& centre, const Vec3& half,
                           double tolerance, const LocalFields* wider) const {
  const auto i = static_cast<std::size_t>(part);
  if (wider != nullptr && (wider->fitted >> i & 1) != 0) {
    local.quadrics[i] = wider->quadrics[i];
    local.fitted |= 1u << i;
    return;
  }
  const Vec3 q = reference(part, centre);
  const double r = reference_radius(part, length(half));
  const bool known = wider != nullptr && (wider->held >> i & 1) != 0;
  local.fields[i] = known ? wider->fields[i].shortened(q, r) : fields_[i].shortened(q, r);
  local.held |= 1u << i;
  // Where a box twice as large was off by more than the eightfold, this one will be off too.
  if (known && wider->misfit[i] > 10 * tolerance) {
    local.misfit[i] = wider->misfit[i];
  } else if (tolerance > 0 && length(half) > least_fitted) {
    fit(local, part, centre, half, tolerance);
  }
}

// The quadric through points on the box, tried at its corners and, so that no fold hides between the points,
// at uneven places inside.
void PosedParts::fit(LocalFields& local, Part part, const Vec3& centre, const Vec3& half,
                     double tolerance) const {
  const auto i = static_cast<std::size_t>(part);
  const auto place = [&](double x, double y, double z) {
    return centre + Vec3{x * half.x, y * half.y, z * half.z};
  };
  const auto field = [&](double x, double y, double z) { return value(part, place(x, y, z), local); };
  Quadric quadric{centre, field(0, 0, 0), {}, {}, {}};
  for (int a = 0; a < 3; ++a) {
    Vec3 u;
    u[a] = 1;
    const double high = field(u.x, u.y, u.z), low = field(-u.x, -u.y, -u.z);
    quadric.slope[a] = 0.5 * (high - low) / half[a];
    quadric.bend[a] = (0.5 * (high + low) - quadric.value) / (half[a] * half[a]);
  }
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    Vec3 u;
    u[b] = u[c] = 1;
    const double rest = 0.5 * (field(u.x, u.y, u.z) + field(-u.x, -u.y, -u.z)) - quadric.value;
    quadric.twist[a] = (rest - quadric.bend[b] * half[b] * half[b] - quadric.bend[c] * half[c] * half[c]) /
                       (half[b] * half[c]);
  }
  for (int corner = 0; corner < 16; ++corner) {
    const Vec3 at = corner < 8 ? Vec3{0.43, 0.57, 0.5} : Vec3{1, 1, 1};
    const double x = corner & 1 ? at.x : -at.x, y = corner & 2 ? at.y : -at.y, z = corner & 4 ? at.z : -at.z;
    local.misfit[i] = std::max(local.misfit[i], std::abs(quadric.at(place(x, y, z)) - field(x, y, z)));
    if (local.misfit[i] > tolerance) return;
  }
  local.quadrics[i] = quadric;
  local.fitted |= 1u << i;
}

Vec3 PosedParts::gradient(Part part, const Vec3& p) const {
  constexpr double h = 1e-4;
  Vec3 g;
  for (int a = 0; a < 3; ++a) {
    Vec3 low = p, high = p;
    low[a] -= h, high[a] += h;
    g[a] = (value(part, high) - value(part, low)) / (2 * h);
  }
  return g;
}

double PosedParts::distance(Part part, const Vec3& p) const {
  // Far from the surface the field's own value is the better distance, and its gradient may vanish.
  constexpr double near = 2, far = 6;
  const double v = value(part, p);
  if (std::abs(v) >= far) return v;
  const double normalised = v / std::clamp(length(gradient(part, p)), 0.1, 10.0);
  return normalised + (v - normalised) * implicit::smooth_step(near, far, std::abs(v));
}

double PosedParts::eye(const Vec3& p) const {
  const Vec3 q = p / parameters_.size;
  return (turgor::distance(Vec3{std::abs(q.x), q.y, q.z}, eye_centre) - eye_radius) * parameters_.size;
}

Vec3 PosedParts::place_bone(const Vec3& reference) const {
  Vec3 q = reference;
  for (int i = 0; i < 40; ++i) q += (reference - without_protrusion(q, bone_share(q))) * 0.7;
  return q * parameters_.size;
}

Vec3 PosedParts::place_soft(const Vec3& reference) const {
  Vec3 q = reference;
  for (int i = 0; i < 40; ++i) q += (reference - without_protrusion(q, soft_share(q))) * 0.7;
  return q * parameters_.size;
}

}  // namespace turgor::phantom
