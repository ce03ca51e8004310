// Solids of a specimen, what holds and pulls them, and their contact.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "turgor/core/index.hpp"
#include "turgor/world/specimen.hpp"
#include "world/scene/bad_input.hpp"
#include "world/scene/name.hpp"
#include "world/scene/transforms.hpp"

namespace turgor {
namespace {

// Where contact is not described by hand.
constexpr double kContactShare = 0.25;     // of the smallest cube
constexpr double kContactStiffness = 2;    // times Young's modulus and the cube's edge
constexpr double kStickSpeedShare = 1e-3;  // of the thickness, in a unit of time

}  // namespace

Result<int> Specimen::add_solid(const std::string& name, SolidPart part) {
  if (body_number(name) >= 0)
    return bad_input(fmt::format("there is tissue '{}' already", name), "Choose another name");
  TissueBody body;
  body.name = name;
  body.solid = std::move(part);
  const auto& points = body.solid->mesh.points;
  state_.position.insert(state_.position.end(), points.begin(), points.end());
  state_.velocity.resize(state_.position.size());
  bodies_.push_back(std::move(body));
  renumber();
  return static_cast<int>(bodies_.size()) - 1;
}

Result<int> Specimen::require_body(const std::string& name) const {
  const int body = body_number(name);
  if (body >= 0) return body;
  std::string all;
  for (std::size_t b = 1; b < bodies_.size(); ++b) all += (all.empty() ? "" : ", ") + bodies_[b].name;
  return bad_input(fmt::format("there is no tissue '{}'", name),
                   all.empty() ? "Build it with flesh_out or voxelize" : "There is " + all);
}

void Specimen::append_solid(MotionModel& model, const TissueBody& body) const {
  const SolidPart& part = *body.solid;
  SpringNetwork& net = model.network;
  net.rest.insert(net.rest.end(), part.mesh.points.begin(), part.mesh.points.end());
  net.mass_g.insert(net.mass_g.end(), part.mass_g.begin(), part.mass_g.end());
  model.mobile.insert(model.mobile.end(), part.mobile.begin(), part.mobile.end());
  Solid moved = part.elements;
  const auto shift = [&](auto& elements) {
    for (auto& element : elements)
      for (int& p : element) p += body.offset;
  };
  shift(moved.tetrahedra);
  shift(moved.edges);
  shift(moved.triangles);
  net.solids.push_back(std::move(moved));
}

// ---- edits ----

// A tetrahedron is in the region where its centre is.
Result<int> Specimen::stiffen_solid(TissueBody& body, const Region& region, double factor) {
  SolidPart& part = *body.solid;
  const Vec3* const x = state_.position.data() + body.offset;
  const std::vector<double> before = part.stiffness;
  int changed = 0;
  for (std::size_t i = 0; i < part.stiffness.size(); ++i) {
    const auto& t = part.mesh.tetrahedra[i];
    if (!region.contains((x[t[0]] + x[t[1]] + x[t[2]] + x[t[3]]) * 0.25)) continue;
    part.stiffness[i] *= factor;
    ++changed;
  }
  if (auto done = refresh_elements(part); !done) {
    part.stiffness = before;
    return done.error();
  }
  forget_model();
  return changed;
}

Result<void> Specimen::set_solid_constants(const std::string& solid, SolidConstants constants) {
  TURGOR_TRY(const int body, require_body(solid));
  if (!bodies_[at(body)].solid)
    return bad_input(fmt::format("'{}' is no solid", solid), "Name one that voxelize has made");
  SolidPart& part = *bodies_[at(body)].solid;
  std::swap(part.constants, constants);
  if (auto done = refresh_elements(part); !done) {
    part.constants = std::move(constants);
    return done.error();
  }
  forget_model();
  return {};
}

Result<int> Specimen::fix_solid(TissueBody& body, const Region& region, bool mobile) {
  SolidPart& part = *body.solid;
  int changed = 0;
  for (std::size_t i = 0; i < part.mobile.size(); ++i) {
    const std::size_t p = at(body.offset) + i;
    if (!region.contains(state_.position[p])) continue;
    part.mobile[i] = mobile ? 1 : 0;
    if (!mobile) state_.velocity[p] = {};
    ++changed;
  }
  forget_model();
  return changed;
}

// ---- attachments ----

Result<int> Specimen::attach(const std::string& name, const Region& region, int object,
                             const ObjectTransform& pose) {
  TURGOR_TRY(const int body, require_body(name));
  TURGOR_TRY(const int held, set_mobile(name, region, false));
  if (held == 0) return 0;
  const ObjectTransform back = inverse(pose);
  if (!is_finite(back)) return bad_input("the object is flat: nothing can hold on to it", "Scale it");
  Attachment attachment{object, body, {}, {}};
  const TissueBody& b = bodies_[at(body)];
  for (int i = 0; i < b.count; ++i) {
    const bool in_layer = b.solid || region.layer < 0 || i / b.flesh.columns() == region.layer;
    const Vec3& p = state_.position[at(b.offset + i)];
    if (!in_layer || !region.contains(p)) continue;
    attachment.samples.push_back(i);
    attachment.places.push_back(back.point(p));
  }
  attachments_.push_back(std::move(attachment));
  return held;
}

// What has become mobile holds on no longer.
void Specimen::detach_mobile(int body) {
  const TissueBody& b = bodies_[at(body)];
  const auto is_mobile = [&](int i) {
    return b.solid ? b.solid->mobile[at(i)] != 0 : b.flesh.samples[at(i)].mobile;
  };
  for (Attachment& attachment : attachments_) {
    if (attachment.body == body) attachment.keep([&](int sample) { return is_mobile(sample) ? -1 : sample; });
  }
  std::erase_if(attachments_, [](const Attachment& a) { return a.samples.empty(); });
}

void Specimen::lead(const Attachment& attachment, const ObjectTransform& pose, double duration) {
  const int offset = bodies_[at(attachment.body)].offset;
  for (std::size_t i = 0; i < attachment.samples.size(); ++i) {
    const std::size_t p = at(offset + attachment.samples[i]);
    const Vec3 target = pose.point(attachment.places[i]);
    if (duration > 0) {
      state_.velocity[p] = (target - state_.position[p]) / duration;
    } else {
      state_.position[p] = target;
      state_.velocity[p] = {};
    }
  }
}

void Specimen::forget_attachments(const std::function<bool(const Attachment&)>& which) {
  for (const Attachment& a : attachments_) {
    if (!which(a)) continue;
    for (const int i : a.samples) state_.velocity[at(bodies_[at(a.body)].offset + i)] = {};
  }
  std::erase_if(attachments_, which);
}

// ---- grabs ----

Grab Specimen::lowered(const NamedGrab& grab) const {
  Grab out;
  for (const int i : grab.samples) out.points.push_back(bodies_[at(grab.body)].offset + i);
  out.weights.assign(out.points.size(),
                     1.0 / static_cast<double>(std::max<std::size_t>(out.points.size(), 1)));
  out.target = grab.target;
  out.stiffness_n_mm = grab.stiffness;
  out.limit_n = grab.limit;
  return out;
}

std::vector<Grab> Specimen::lowered_grabs() const {
  std::vector<Grab> all;
  for (const NamedGrab& grab : grabs_) all.push_back(lowered(grab));
  return all;
}

Vec3 Specimen::force_of(const NamedGrab& grab) const {
  return respond(lowered(grab), state_.position).force;
}

Result<void> Specimen::set_grab(NamedGrab grab) {
  TURGOR_CHECK(check_name(grab.name));
  TURGOR_CHECK(validate(lowered(grab), state_.position.size()));
  const auto found =
      std::find_if(grabs_.begin(), grabs_.end(), [&](const NamedGrab& g) { return g.name == grab.name; });
  if (found == grabs_.end())
    grabs_.push_back(std::move(grab));
  else
    *found = std::move(grab);
  if (implicit_) TURGOR_CHECK(implicit_->set_grabs(lowered_grabs()));
  return stepper_ ? stepper_->set_grabs(lowered_grabs()) : Result<void>();
}

Result<void> Specimen::release(const std::string& name) {
  if (std::erase_if(grabs_, [&](const NamedGrab& g) { return g.name == name; }) == 0)
    return bad_input(fmt::format("there is no grab '{}'", name), "Make it with grab first");
  if (implicit_) TURGOR_CHECK(implicit_->set_grabs(lowered_grabs()));
  return stepper_ ? stepper_->set_grabs(lowered_grabs()) : Result<void>();
}

// ---- contact ----

Result<void> Specimen::set_contact(const std::optional<SolidContactOptions>& options) {
  if (options) {
    for (const double x : {options->thickness, options->stiffness, options->friction}) {
      if (!(std::isfinite(x) && x >= 0))
        return bad_input(fmt::format("{} is out of range for contact", x),
                         "Give finite numbers of at least 0");
    }
  }
  contact_ = options;
  forget_model();
  return {};
}

std::optional<ContactModel> Specimen::contact_model() const {
  if (!contact_) return std::nullopt;
  ContactModel model;
  double edge = std::numeric_limits<double>::infinity(), modulus = 0;
  for (const TissueBody& body : bodies_) {
    if (!body.solid) continue;
    ContactSurface surface;
    surface.self = contact_->self;
    for (Index3 t : body.solid->mesh.surface_triangles) {
      for (int& p : t) p += body.offset;
      surface.triangles.push_back(t);
    }
    model.surfaces.push_back(std::move(surface));
    const auto& edges = body.solid->elements.edges;
    const auto& x = body.solid->mesh.points;
    for (const auto& [a, b] : edges) edge = std::min(edge, distance(x[at(a)], x[at(b)]));
    modulus = std::max(modulus, body.solid->options.material.youngs_modulus_mpa);
  }
  if (model.surfaces.empty()) return std::nullopt;
  model.thickness_mm = contact_->thickness > 0 ? contact_->thickness : kContactShare * edge;
  model.stiffness_n_mm = contact_->stiffness > 0 ? contact_->stiffness : kContactStiffness * modulus * edge;
  model.friction = contact_->friction;
  model.stick_mm_ms = kStickSpeedShare * model.thickness_mm;
  return model;
}

}  // namespace turgor
