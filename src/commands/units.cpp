#include "units.hpp"

namespace turgor {

std::string_view symbol(Unit unit) {
  switch (unit) {
    case Unit::none:
      return "";
    case Unit::mm:
      return "mm";
    case Unit::deg:
      return "deg";
    case Unit::hu:
      return "HU";
    case Unit::fraction:
      return "fraction";
    case Unit::mpa:
      return "MPa";
    case Unit::newton:
      return "N";
  }
  return "";
}

namespace commands {
namespace {

constexpr Suffix kLengths[] = {{"mm"}, {"cm", 10}, {"m", 1000}};
constexpr Suffix kAngles[] = {{"deg"}, {"°"}, {"rad", 180, 3.14159265358979323846}};
constexpr Suffix kHounsfield[] = {{"HU"}};
constexpr Suffix kFractions[] = {{"%", 1, 100}};
constexpr Suffix kPressures[] = {{"MPa"}, {"kPa", 1, 1000}, {"Pa", 1, 1'000'000}};
constexpr Suffix kForces[] = {{"N"}, {"mN", 1, 1000}, {"kN", 1000}};

}  // namespace

std::span<const Suffix> suffixes(Unit unit) {
  switch (unit) {
    case Unit::none:
      return {};
    case Unit::mm:
      return kLengths;
    case Unit::deg:
      return kAngles;
    case Unit::hu:
      return kHounsfield;
    case Unit::fraction:
      return kFractions;
    case Unit::mpa:
      return kPressures;
    case Unit::newton:
      return kForces;
  }
  return {};
}

}  // namespace commands
}  // namespace turgor
