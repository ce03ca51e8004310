#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "turgor/tissue/network.hpp"

namespace turgor {
namespace {

// Those that are the same for doubling and halving.
constexpr std::array kLaws = {SpringLaw::linear, SpringLaw::exponential, SpringLaw::logarithmic,
                              SpringLaw::square};
constexpr std::array kStrains = {1e-7, 1e-4, 0.01, 0.1, 0.1999, 0.2001, 0.24,
                                 0.26, 0.5,  1.0,  2.5, 6.0,    20.0,   49.0};

Spring make_spring(SpringLaw law) {
  return {0, 1, 3.0, 0.7, law, SpringKind::membrane};
}

double law_of(SpringLaw law, double s) {
  switch (law) {
    case SpringLaw::linear:
      return s;
    case SpringLaw::exponential:
      return std::exp(s) - 1;
    case SpringLaw::logarithmic:
      return std::log(s + 1);
    case SpringLaw::square:
      return s * s;
    case SpringLaw::collagen:
      return s < 0.1 ? 5 * s * s : s - 0.05;
    case SpringLaw::hookean:
      return s;
  }
  return 0;
}

// The work done against `respond().tension` from rest to `length`: composite Simpson, in the logarithm of the
// length.
double work(const Spring& spring, double length) {
  const double from = std::log(spring.rest_length_mm), to = std::log(length);
  constexpr int n = 20'000;
  double sum = 0;
  for (int i = 0; i <= n; ++i) {
    const double l = std::exp(from + (to - from) * i / n);
    sum += respond(spring, l).tension * l * (i == 0 || i == n ? 1 : i % 2 == 1 ? 4 : 2);
  }
  return sum * (to - from) / n / 3;
}

TEST(SpringLaw, IsTheLawOfStrainTheSameForDoublingAndHalving) {
  for (const SpringLaw law : kLaws) {
    const Spring spring = make_spring(law);
    for (const double s : kStrains) {
      const double expected = spring.stiffness_n * law_of(law, s);
      EXPECT_NEAR(respond(spring, 3.0 * (1 + s)).tension / expected, 1, 1e-8)
          << static_cast<int>(law) << ' ' << s;
      EXPECT_NEAR(respond(spring, 3.0 / (1 + s)).tension / -expected, 1, 1e-8)
          << static_cast<int>(law) << ' ' << s;
    }
  }
}

TEST(SpringLaw, IsAtRestWithoutForceOrEnergy) {
  for (const SpringLaw law : kLaws) {
    const SpringResponse r = respond(make_spring(law), 3.0);
    EXPECT_EQ(r.energy, 0);
    EXPECT_EQ(r.tension, 0);
    EXPECT_GE(r.slope, 0);
  }
}

TEST(SpringLaw, TensionIsTheSlopeOfTheEnergyAndSlopeThatOfTheTension) {
  for (const SpringLaw law : kLaws) {
    const Spring spring = make_spring(law);
    for (const double s : kStrains) {
      if (s < 1e-3) continue;  // the difference quotient loses its digits there; the work test covers it
      for (const double length : {3.0 * (1 + s), 3.0 / (1 + s)}) {
        const double h = 1e-4 * std::min(length, std::abs(length - 3.0));
        const SpringResponse low = respond(spring, length - h), high = respond(spring, length + h);
        const SpringResponse r = respond(spring, length);
        EXPECT_NEAR((high.energy - low.energy) / (2 * h) / r.tension, 1, 1e-5)
            << static_cast<int>(law) << ' ' << s;
        EXPECT_NEAR((high.tension - low.tension) / (2 * h) / r.slope, 1, 1e-5)
            << static_cast<int>(law) << ' ' << s;
      }
    }
  }
}

TEST(SpringLaw, EnergyIsTheWorkDoneToRoundOffEvenForTheSmallestStrain) {
  for (const SpringLaw law : kLaws) {
    const Spring spring = make_spring(law);
    for (const double s : kStrains) {
      if (s > 7) continue;
      for (const double length : {3.0 * (1 + s), 3.0 / (1 + s)}) {
        // Simpson on a tension whose round-off near rest is relative to the strain.
        const double tolerance = 1e-11 + 1e-15 / s;
        EXPECT_NEAR(respond(spring, length).energy / work(spring, length), 1, tolerance)
            << static_cast<int>(law) << ' ' << s;
      }
    }
  }
}

TEST(SpringLaw, ExponentialCompressionAgreesWithTheExponentialIntegral) {
  const Spring spring = make_spring(SpringLaw::exponential);
  for (const double s : {0.3, 1.0, 2.0, 7.5, 30.0, 50.0}) {
    const double closed = (std::expint(1 + s) - std::expint(1.0)) / std::exp(1.0) - std::expm1(s) / (1 + s);
    EXPECT_NEAR(respond(spring, 3.0 / (1 + s)).energy / (0.7 * 3.0 * closed), 1, 1e-12) << s;
  }
}

TEST(SpringLaw, StaysFiniteSmoothAndMonotonicWhereTheStrainHasNoBound) {
  for (const SpringLaw law : kLaws) {
    const Spring spring = make_spring(law);
    for (const double length : {0.0, 1e-300, 1e-12, 3.0 / 51, 3.0 * 51, 1e6, 1e100}) {
      const SpringResponse r = respond(spring, length);
      EXPECT_TRUE(std::isfinite(r.energy) && std::isfinite(r.tension) && std::isfinite(r.slope));
      EXPECT_GE(r.slope, 0);
      EXPECT_GT(r.energy, 0);
    }
    for (const double edge : {3.0 / 51, 3.0 * 51}) {
      const SpringResponse inside = respond(spring, edge * (1 - 1e-9)),
                           outside = respond(spring, edge * (1 + 1e-9));
      EXPECT_NEAR(inside.energy / outside.energy, 1, 1e-6);
      EXPECT_NEAR(inside.tension / outside.tension, 1, 1e-6);
      EXPECT_NEAR(inside.slope / outside.slope, 1, 1e-6);
    }
    EXPECT_LT(respond(spring, 0).tension, respond(spring, 0.01).tension);
    EXPECT_GT(respond(spring, 1e5).tension, respond(spring, 1e4).tension);
  }
}

TEST(SpringLaw, CollagenIsSlackUntilItsRestLengthAndTakesUpEvenly) {
  const Spring spring = make_spring(SpringLaw::collagen);
  for (const double length : {0.0, 1e-300, 0.01, 1.5, 2.999999}) {
    const SpringResponse r = respond(spring, length);
    EXPECT_EQ(r.energy, 0);
    EXPECT_EQ(r.tension, 0);
    EXPECT_EQ(r.slope, 0);
  }
  for (const double s : kStrains) {
    const double length = 3.0 * (1 + s), h = 1e-4 * 3.0 * s;
    const SpringResponse low = respond(spring, length - h), high = respond(spring, length + h);
    const SpringResponse r = respond(spring, length);
    EXPECT_NEAR(r.tension / (0.7 * law_of(SpringLaw::collagen, s)), 1, 1e-8) << s;
    EXPECT_NEAR(r.energy / work(spring, length), 1, 1e-7 + 1e-15 / s) << s;  // Simpson at the kink of f''
    if (s < 1e-3) continue;
    EXPECT_NEAR((high.energy - low.energy) / (2 * h) / r.tension, 1, 1e-5) << s;
    EXPECT_NEAR((high.tension - low.tension) / (2 * h) / r.slope, 1, s == 0.1 ? 1e-4 : 1e-5) << s;
  }
  EXPECT_GT(respond(spring, 1e5).tension, respond(spring, 1e4).tension);
}

TEST(VolumeElement, StressIsTheSlopeOfTheEnergyAndRestoresAnInvertedElement) {
  const VolumeElement plain{{0, 1, 2, 3}, 2.5, 0.3};
  const VolumeElement guarded{{0, 1, 2, 3}, 2.5, 0.3, 4.0};
  for (const VolumeElement& v : {plain, guarded}) {
    for (const double volume : {-3.0, -0.1, 0.1, 0.499, 1.0, 2.5, 4.0}) {
      const double h = 1e-6;
      const VolumeResponse low = respond(v, volume - h), high = respond(v, volume + h),
                           r = respond(v, volume);
      EXPECT_NEAR((high.energy - low.energy) / (2 * h), r.mean_stress, 1e-8 * (1 + std::abs(r.mean_stress)));
      EXPECT_NEAR((high.mean_stress - low.mean_stress) / (2 * h), r.slope, 1e-7 * (1 + r.slope));
    }
    EXPECT_LT(respond(v, -1.0).mean_stress, 0);
  }
  EXPECT_EQ(respond(plain, 2.5).energy, 0);
  EXPECT_EQ(respond(guarded, 0.5).mean_stress, respond(plain, 0.5).mean_stress)
      << "no guard above a fifth of V0";
  EXPECT_NEAR(respond(guarded, 0.0).mean_stress, respond(plain, 0.0).mean_stress - 4.0, 1e-12);
}

TEST(SpringLaw, HookeanIsLinearInStretchAndCompressionDownToLengthZero) {
  const Spring spring = make_spring(SpringLaw::hookean);
  for (const double strain : {-1.0, -0.999, -0.5, -1e-6, 0.0, 1e-6, 0.5, 2.0, 80.0}) {
    const double length = 3.0 * (1 + strain);
    const SpringResponse r = respond(spring, length);
    const double expected = (length - 3.0) / 3.0;
    EXPECT_NEAR(r.tension, 0.7 * expected, 1e-15) << strain;
    EXPECT_DOUBLE_EQ(r.slope, 0.7 / 3.0) << strain;
    EXPECT_NEAR(r.energy, 0.7 * 3.0 * 0.5 * expected * expected, 1e-12 * (1 + r.energy)) << strain;
  }
}

}  // namespace
}  // namespace turgor
