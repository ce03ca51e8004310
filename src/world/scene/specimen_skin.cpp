// The outermost layer of a flesh as skin: collagen, Langer's lines, tension at rest (Pieper 1989, section
// 2.1.2).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "turgor/core/index.hpp"
#include "turgor/world/specimen.hpp"
#include "world/langer.hpp"
#include "world/scene/bad_input.hpp"

namespace turgor {
namespace {

bool within(double x, double low, double high) {
  return std::isfinite(x) && x >= low && x <= high;
}

}  // namespace

Result<void> validate(const SkinLayer& skin, int columns) {
  constexpr double most = 1e12, most_strain = 5;
  if (!within(skin.collagen, 0, most))
    return bad_input(fmt::format("the constant of collagen is {}", skin.collagen), "Give at least 0");
  if (!within(skin.transition_along, 0, most_strain) || !within(skin.transition_across, 0, most_strain) ||
      !within(skin.rest_strain, 0, most_strain)) {
    return bad_input("a strain of the skin is out of range", "Give 0 to 5");
  }
  if (!(skin.anisotropy > 0 && skin.anisotropy <= 1e6)) {
    return bad_input(fmt::format("the anisotropy is {}", skin.anisotropy), "Give a number above 0");
  }
  if (skin.langer.size() != 1 && skin.langer.size() != at(columns)) {
    return bad_input(
        fmt::format("{} directions of Langer's lines are given for {} columns", skin.langer.size(), columns),
        "Give one for all, or one for each vertex");
  }
  for (const Vec3& d : skin.langer) {
    if (!is_within_reach(d) || !(squared_length(d) > 0))
      return bad_input("a direction of Langer's lines has no length", "Give another one");
  }
  return {};
}

Result<void> Specimen::set_skin(const std::string& name, SkinLayer skin) {
  TURGOR_TRY(const int body, require_flesh(name));
  TissueBody& b = bodies_[at(body)];
  TURGOR_CHECK(validate(skin, b.flesh.columns()));
  for (Vec3& d : skin.langer) d = normalized(d);
  relaxation_ = skin.relaxation;
  b.skin = std::move(skin);
  forget_model();
  return {};
}

// Beside every spring within the layer stands one of collagen; between along and across the lines its
// constant and its slack follow the squared cosine of the angle.
void Specimen::append_skin(MotionModel& model, const TissueBody& body, std::size_t first_spring) const {
  if (!body.skin) return;
  const SkinLayer& skin = *body.skin;
  const bool relaxes = std::any_of(skin.relaxation.begin(), skin.relaxation.end(),
                                   [](const Relaxation& r) { return r.share > 0; });
  const int top = body.flesh.layers - 1, columns = body.flesh.columns();
  const std::size_t count = body.parts.network.springs.size();
  for (std::size_t i = 0; i < count; ++i) {
    const Spring& part = body.parts.network.springs[i];
    const bool in_layer = part.kind == SpringKind::membrane || part.kind == SpringKind::plate;
    if (!in_layer || body.parts.layer_of_spring[i] != top) continue;
    Spring& elastin = model.network.springs[first_spring + i];
    elastin.rest_length_mm /= 1 + skin.rest_strain;
    model.springs[first_spring + i].relaxes = relaxes;
    if (!(skin.collagen > 0)) continue;
    const Vec3 along = normalized(body.parts.network.rest[at(part.b)] - body.parts.network.rest[at(part.a)]);
    const Vec3& lines = skin.langer[skin.langer.size() == 1 ? 0 : at(part.a % columns)];
    const double cosine = dot(along, lines), squared = cosine * cosine;
    Spring collagen = elastin;
    collagen.law = SpringLaw::collagen;
    collagen.stiffness_n = at_angle(skin.collagen, skin.collagen / skin.anisotropy, squared);
    const double slack = at_angle(skin.transition_along, skin.transition_across, squared);
    collagen.rest_length_mm = part.rest_length_mm * (1 + slack);
    model.network.springs.push_back(collagen);
    model.springs.push_back(model.springs[first_spring + i]);
  }
}

}  // namespace turgor
