// Edits of a specimen's tissue: growth, stiffness, removal, refinement (Pieper 1989, section 6.2). Samples
// that stay keep their motion; fibres and collisions follow the new numbers.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "turgor/core/index.hpp"
#include "turgor/world/specimen.hpp"
#include "world/scene/bad_input.hpp"

namespace turgor {
Result<int> Specimen::require_flesh(const std::string& name) const {
  TURGOR_TRY(const int body, require_body(name));
  if (!bodies_[at(body)].solid) return body;
  return bad_input(fmt::format("'{}' is a solid, which has no layers", name),
                   "Name a flesh; of solids `fix`, `attach` and `stiffen` change regions");
}

// Renumbers what refers to a body's samples, and carries their motion over.
void Specimen::carry_over(int body, const FleshMap& map) {
  TissueBody& b = bodies_[at(body)];
  MotionState next;
  next.time_ms = state_.time_ms;
  for (const auto field : {&MotionState::position, &MotionState::velocity}) {
    const std::vector<Vec3>& old = state_.*field;
    std::vector<Vec3>& now = next.*field;
    now.assign(old.begin(), old.begin() + b.offset);
    for (const Edge& e : map.origin)
      now.push_back((old[at(b.offset + e[0])] + old[at(b.offset + e[1])]) * 0.5);
    now.insert(now.end(), old.begin() + b.offset + b.count, old.end());
  }
  state_ = std::move(next);

  const auto follow = [&](SampleRef& ref) {
    if (ref.body != body) return true;
    ref.number = map.new_of_old[at(ref.number)];
    return ref.number >= 0;
  };
  const auto lost = [&](Fibre& fibre) {
    const bool a = follow(fibre.a), c = follow(fibre.b);
    return !a || !c;
  };
  std::erase_if(shocks_, lost);
  for (Muscle& muscle : muscles_) std::erase_if(muscle.fibres, lost);
  for (auto& handle : handles_) {
    if (handle && !follow(*handle)) handle.reset();
  }
  for (Attachment& attachment : attachments_) {
    if (attachment.body == body) attachment.keep([&](int sample) { return map.new_of_old[at(sample)]; });
  }
  for (NamedGrab& grab : grabs_) {
    if (grab.body != body) continue;
    for (int& sample : grab.samples) sample = map.new_of_old[at(sample)];
    std::erase(grab.samples, -1);
  }
  std::erase_if(grabs_, [](const NamedGrab& grab) { return grab.samples.empty(); });
  if (b.skin && b.skin->langer.size() > 1) {
    const std::vector<Vec3> old = std::move(b.skin->langer);
    b.skin->langer.clear();
    for (int column = 0; column < b.flesh.columns(); ++column) {
      const auto& [one, other] = map.origin[at(column)];  // layer 0: samples are columns
      const Vec3 second = old[at(other)] * (dot(old[at(one)], old[at(other)]) < 0 ? -1.0 : 1.0);
      b.skin->langer.push_back(normalized(old[at(one)] + second));
    }
  }
  renumber();
}

std::vector<bool> Specimen::columns_in(const TissueBody& body, const Region& region) const {
  const int columns = body.flesh.columns(), top = body.flesh.layers - 1;
  std::vector<bool> in(at(columns));
  for (int c = 0; c < columns; ++c) {
    const int layer = region.layer >= 0 ? std::min(region.layer, top) : top;
    in[at(c)] = region.contains(state_.position[at(body.offset + body.flesh.sample(layer, c))]);
  }
  return in;
}

namespace {

// Every sample of the region, in present places.
template <class Change>
int change_samples(Flesh& flesh, const Vec3* position, const Region& region, Change&& change) {
  int changed = 0;
  for (int i = 0; i < static_cast<int>(flesh.samples.size()); ++i) {
    if (region.layer >= 0 && i / flesh.columns() != region.layer) continue;
    if (!region.contains(position[i])) continue;
    change(flesh.samples[at(i)]);
    ++changed;
  }
  return changed;
}

}  // namespace

// Copies the body, edits the copy, and takes it where it is sound. Of a refined body the base is edited,
// whose columns come first in the refined one: samples between others follow theirs.
template <class Edit>
Result<int> Specimen::edit(const std::string& name, Edit&& change) {
  TURGOR_TRY(const int body, require_flesh(name));
  TissueBody next = bodies_[at(body)];
  const Vec3* const position = state_.position.data() + next.offset;
  int changed = 0;
  if (next.adaptive) {
    Flesh base = next.adaptive->base();
    std::vector<Vec3> places;
    for (int layer = 0; layer < base.layers; ++layer) {
      const Vec3* const first = position + next.flesh.sample(layer, 0);
      places.insert(places.end(), first, first + base.columns());
    }
    changed = change(base, places.data());
    TURGOR_CHECK(next.adaptive->set_base(std::move(base)));
    next.flesh = next.adaptive->flesh();
  } else {
    changed = change(next.flesh, position);
  }
  TURGOR_CHECK(rebuild(next));
  bodies_[at(body)] = std::move(next);
  forget_model();
  return changed;
}

Result<int> Specimen::scale_growth(const std::string& body, const Region& region, double factor) {
  if (!(std::isfinite(factor) && factor > 0))
    return bad_input(fmt::format("the factor is {}", factor), "Give a number above 0");
  return edit(body, [&](Flesh& flesh, const Vec3* position) {
    return change_samples(flesh, position, region, [&](FleshSample& s) { s.growth *= factor; });
  });
}

Result<int> Specimen::scale_stiffness(const std::string& body, const Region& region, double factor) {
  if (!(std::isfinite(factor) && factor >= 0))
    return bad_input(fmt::format("the factor is {}", factor), "Give at least 0");
  TURGOR_TRY(const int number, require_body(body));
  if (bodies_[at(number)].solid) return stiffen_solid(bodies_[at(number)], region, factor);
  return edit(body, [&](Flesh& flesh, const Vec3* position) {
    return change_samples(flesh, position, region, [&](FleshSample& s) { s.stiffness *= factor; });
  });
}

Result<int> Specimen::set_mobile(const std::string& body, const Region& region, bool mobile) {
  TURGOR_TRY(const int number, require_body(body));
  auto changed =
      bodies_[at(number)].solid
          ? fix_solid(bodies_[at(number)], region, mobile)
          : edit(body, [&](Flesh& flesh, const Vec3* position) {
              return change_samples(flesh, position, region, [&](FleshSample& s) { s.mobile = mobile; });
            });
  if (changed && mobile) detach_mobile(number);
  return changed;
}

Result<int> Specimen::set_volume(const std::string& body, double modulus, double guard) {
  return edit(body, [&](Flesh& flesh, const Vec3*) {
    flesh.volume_modulus_mpa = modulus;
    flesh.inversion_guard_mpa = guard;
    return flesh.surface.polygon_count();
  });
}

Result<int> Specimen::remove(const std::string& name, const Region& region) {
  TURGOR_TRY(const int body, require_flesh(name));
  TissueBody next = bodies_[at(body)];
  next.adaptive.reset();
  next.refinement.reset();  // what is left would be refined once more, as a base of its own
  const std::vector<bool> gone = columns_in(next, region);
  const auto changed = static_cast<int>(std::count(gone.begin(), gone.end(), true));
  if (changed == 0) return 0;
  TURGOR_TRY(const FleshMap map, remove_columns(next.flesh, gone));
  TURGOR_CHECK(rebuild(next));
  bodies_[at(body)] = std::move(next);
  carry_over(body, map);
  return changed;
}

Result<int> Specimen::refine(const std::string& name, const std::optional<RefinementOptions>& options) {
  TURGOR_TRY(const int body, require_flesh(name));
  TissueBody& b = bodies_[at(body)];
  if (options) {
    const bool sound = std::isfinite(options->refine_above) && options->merge_below >= 0 &&
                       options->merge_below < options->refine_above && options->most_levels >= 0;
    if (!sound)
      return bad_input("the limits of refinement are out of order",
                       "Give merge below refine, both of at least 0");
  }
  b.refinement = options;
  if (options) return adapt();
  if (!b.adaptive) return 0;
  RefinementOptions join;
  join.most_levels = 0;
  b.refinement = join;
  bool joined = false;
  Result<bool> changed = true;
  while (changed && *changed) {  // a level each time
    changed = adapt_body(body);
    joined = joined || (changed && *changed);
  }
  bodies_[at(body)].refinement.reset();
  if (!changed) return changed.error();
  return joined ? 1 : 0;
}

Result<int> Specimen::adapt() {
  int changed = 0;
  for (int i = 1; i < static_cast<int>(bodies_.size()); ++i) {
    if (!bodies_[at(i)].refinement) continue;
    TURGOR_TRY(const bool done, adapt_body(i));
    changed += done ? 1 : 0;
  }
  return changed;
}

Result<bool> Specimen::adapt_body(int body) {
  TissueBody next = bodies_[at(body)];
  if (!next.adaptive) next.adaptive.emplace(next.flesh);
  const auto measure = polygon_strain(next.adaptive->flesh(), positions_of(next));
  TURGOR_TRY(const FleshMap map, next.adaptive->adapt(measure, *next.refinement));
  const Flesh& flesh = next.adaptive->flesh();
  if (flesh.surface.corners == next.flesh.surface.corners) return false;
  next.flesh = flesh;
  TURGOR_CHECK(rebuild(next));
  bodies_[at(body)] = std::move(next);
  carry_over(body, map);
  return true;
}

}  // namespace turgor
