#include "anatomy/phantom_pose.hpp"

namespace turgor::phantom {
namespace {

// Depths in mm at size 1.
constexpr double dermis = 1.8, cortex = 2.0, enamel = 1.1, mucosa = 1.5;
constexpr double crown_height = 8;

enum Rank {
  in_enamel,
  in_dentine,
  in_marrow,
  in_bone,
  in_eye,
  in_brain,
  in_air,
  in_cartilage,
  in_muscle,
  in_fat,
  in_skin,
  in_holder,
  outside
};

}  // namespace

const std::array<Layer, TissueProbe::layer_count> TissueProbe::layers{{
    {PhantomLabel::upper_teeth, 2500},
    {PhantomLabel::upper_teeth, 1850},
    {PhantomLabel::skull, 600},
    {PhantomLabel::skull, 1450},
    {PhantomLabel::eye, 15},
    {PhantomLabel::brain, 35},
    {PhantomLabel::airway, -1000},
    {PhantomLabel::cartilage, 110},
    {PhantomLabel::muscle, 50},
    {PhantomLabel::fat, -100},
    {PhantomLabel::skin, 60},
    {PhantomLabel::holder, 450},
    {PhantomLabel::air, -1000},
}};

double TissueProbe::field(Part part) {
  const auto i = static_cast<std::size_t>(part);
  if ((known_ >> i & 1) == 0) {
    values_[i] = local_ != nullptr ? parts_.value(part, p_, *local_) : parts_.value(part, p_);
    known_ |= 1u << i;
  }
  return values_[i];
}

double TissueProbe::outline(int layer) {
  const double size = parts_.parameters().size;
  switch (layer) {
    case in_enamel: {
      const double upper = field(Part::upper_teeth), lower = field(Part::lower_teeth);
      const double from_edge = std::abs(p_.z - occlusal_height(p_.y / size) * size);
      return std::max(
          {std::min(upper, lower), -enamel * size - std::min(upper, lower), from_edge - crown_height * size});
    }
    case in_dentine:
      return std::min(field(Part::upper_teeth), field(Part::lower_teeth));
    case in_marrow:
      return std::min(field(Part::skull), field(Part::mandible)) + cortex * size;
    case in_bone:
      return std::min(field(Part::skull), field(Part::mandible));
    case in_eye:
      return parts_.eye(p_);
    case in_brain:
      return field(Part::brain);
    case in_air:
      return field(Part::air);
    case in_cartilage:
      return std::max(field(Part::cartilage), field(Part::skin) + dermis * size);
    case in_muscle: {
      return std::max(std::min(field(Part::muscle), field(Part::air) - mucosa * size),
                      field(Part::skin) + 1.3 * dermis * size);
    }
    case in_fat:
      return field(Part::skin) + dermis * size;
    case in_skin:
      return field(Part::skin);
    case in_holder:
      return parts_.parameters().head_holder ? field(Part::holder) : 1e9;
    default:
      return -1e9;
  }
}

double TissueProbe::slope(Part part, double radius) {
  const auto i = static_cast<std::size_t>(part);
  if ((known_slopes_ >> i & 1) == 0) {
    slopes_[i] = parts_.lipschitz(part, p_, radius);
    known_slopes_ |= 1u << i;
  }
  return slopes_[i];
}

double TissueProbe::lipschitz(int layer, double radius) {
  const std::uint32_t needed = parts_of(1u << layer);
  double most = layer == in_eye ? 1 : 0;
  for (std::size_t i = 0; i < part_count; ++i) {
    if ((needed >> i & 1) != 0) most = std::max(most, slope(static_cast<Part>(i), radius));
  }
  // The occlusal plane of the enamel's outline leans.
  return layer == in_enamel ? std::max(most, 1.01) : most;
}

std::uint32_t TissueProbe::parts_of(std::uint32_t layer_bits) {
  const auto bits = [](std::initializer_list<Part> list) {
    std::uint32_t all = 0;
    for (const Part part : list) all |= 1u << static_cast<int>(part);
    return all;
  };
  static constexpr auto teeth = {Part::upper_teeth, Part::lower_teeth};
  static constexpr auto bone = {Part::skull, Part::mandible};
  std::uint32_t all = 0;
  for (int layer = 0; layer < layer_count; ++layer) {
    if ((layer_bits >> layer & 1) == 0) continue;
    switch (layer) {
      case in_enamel:
      case in_dentine:
        all |= bits(teeth);
        break;
      case in_marrow:
      case in_bone:
        all |= bits(bone);
        break;
      case in_brain:
        all |= bits({Part::brain});
        break;
      case in_air:
        all |= bits({Part::air});
        break;
      case in_cartilage:
        all |= bits({Part::cartilage, Part::skin});
        break;
      case in_muscle:
        all |= bits({Part::muscle, Part::air, Part::skin});
        break;
      case in_fat:
      case in_skin:
        all |= bits({Part::skin});
        break;
      case in_holder:
        all |= bits({Part::holder});
        break;
      default:
        break;
    }
  }
  return all;
}

PhantomLabel TissueProbe::label(int layer) {
  const PhantomLabel label = layers[static_cast<std::size_t>(layer)].label;
  if (label == PhantomLabel::upper_teeth && field(Part::lower_teeth) < field(Part::upper_teeth)) {
    return PhantomLabel::lower_teeth;
  }
  if (label == PhantomLabel::skull && field(Part::mandible) < field(Part::skull))
    return PhantomLabel::mandible;
  // Nostrils and slit beyond the lid are outside air.
  if (label == PhantomLabel::airway && field(Part::skin) >= 0) return PhantomLabel::air;
  return label;
}

bool TissueProbe::same_label(int layer, double radius) {
  const auto apart = [&](Part a, Part b) {
    return std::abs(field(a) - field(b)) > radius * (slope(a, radius) + slope(b, radius));
  };
  switch (layer) {
    case in_enamel:
    case in_dentine:
      return apart(Part::upper_teeth, Part::lower_teeth);
    case in_marrow:
    case in_bone:
      return apart(Part::skull, Part::mandible);
    case in_air:
      return std::abs(field(Part::skin)) > radius * slope(Part::skin, radius);
    default:
      return true;
  }
}

}  // namespace turgor::phantom
