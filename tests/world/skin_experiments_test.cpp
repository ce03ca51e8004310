#include "turgor/world/skin_experiments.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace turgor {
namespace {

SkinCurve curve_of(Result<SkinCurve> result) {
  EXPECT_TRUE(static_cast<bool>(result)) << (result ? "" : result.error().message());
  return result ? *std::move(result) : SkinCurve{};
}

SkinProperties without_relaxation() {
  SkinProperties skin;
  for (Relaxation& r : skin.relaxation) r.share = 0;
  return skin;
}

/// Tension at a strain of a curve that rises in strain from `begin`, linearly between samples.
double tension_at(const SkinCurve& c, double strain, std::size_t begin = 0) {
  for (std::size_t i = begin; i + 1 < c.strain.size(); ++i) {
    const double a = c.strain[i], b = c.strain[i + 1];
    if ((a <= strain && strain <= b) || (b <= strain && strain <= a))
      return a == b
                 ? c.tension_n_cm[i]
                 : c.tension_n_cm[i] + (c.tension_n_cm[i + 1] - c.tension_n_cm[i]) * (strain - a) / (b - a);
  }
  ADD_FAILURE() << "no strain " << strain;
  return 0;
}

TEST(SkinExperiments, AStripOfRowsPullsAsTheSumOfItsSprings) {
  SkinProperties skin = without_relaxation();
  skin.shear = 0;
  for (const double angle : {0.0, 90.0, 30.0}) {
    skin.langer_deg = angle;
    Context context;
    const SkinCurve c = curve_of(pull_skin(skin, {0.8, 0.1, 1, false}, context));
    ASSERT_EQ(c.strain.size(), 201U);
    EXPECT_NEAR(c.strain.back(), 0.8, 1e-12);
    for (std::size_t i = 0; i < c.strain.size(); ++i) {
      const double closed = elastic_skin_tension(skin, c.strain[i]);
      EXPECT_NEAR(c.tension_n_cm[i], closed, 1e-9 * (1 + closed)) << angle << ' ' << c.strain[i];
    }
  }
}

TEST(SkinExperiments, LoadIsLaxFirstThenStiff) {
  Context context;
  const SkinCurve c = curve_of(pull_skin({}, {0.7, 0.05, 1, false}, context));
  const auto slope = [&](double strain) {
    return (tension_at(c, strain + 0.02) - tension_at(c, strain)) / 0.02;
  };
  EXPECT_GT(slope(0.65), 6 * slope(0.05));
  EXPECT_NEAR(slope(0.25) / slope(0.05), 1, 0.35) << "lax until the transition";
  EXPECT_TRUE(std::is_sorted(c.tension_n_cm.begin(), c.tension_n_cm.end()));
}

TEST(SkinExperiments, SkinIsLaxerAcrossLangersLines) {
  Context context;
  SkinProperties across;
  across.langer_deg = 90;
  const SkinPull pull{0.7, 0.05, 1, false};
  const SkinCurve a = curve_of(pull_skin({}, pull, context)), b = curve_of(pull_skin(across, pull, context));
  EXPECT_GT(tension_at(a, 0.5), 2 * tension_at(b, 0.5));
  EXPECT_NEAR(tension_at(a, 0.1) / tension_at(b, 0.1), 1, 0.05) << "elastin has no direction";
}

TEST(SkinExperiments, UnloadingRunsBelowLoading) {
  Context context;
  const SkinCurve c = curve_of(pull_skin({}, {}, context));
  const auto peak =
      static_cast<std::size_t>(std::max_element(c.strain.begin(), c.strain.end()) - c.strain.begin());
  EXPECT_NEAR(c.strain[peak], 0.6, 1e-9);
  for (const double strain : {0.15, 0.2, 0.3, 0.4, 0.5, 0.58})
    EXPECT_GT(tension_at(c, strain), 1.02 * tension_at(c, strain, peak)) << strain;
}

TEST(SkinExperiments, SkinIsNotPushedWhenItHasGoneSlack) {
  Context context;
  const SkinCurve c = curve_of(pull_skin({}, {0.5, 0.05, 3, true}, context));
  for (std::size_t i = 0; i < c.strain.size(); ++i) EXPECT_GT(c.tension_n_cm[i], -1e-3) << i;
  EXPECT_GT(c.strain.back(), 0.01) << "longer by what has relaxed";
  EXPECT_LT(c.strain.back(), 0.2);
}

TEST(SkinExperiments, WithoutRelaxationLoadingAndUnloadingAreOne) {
  Context context;
  const SkinCurve c = curve_of(pull_skin(without_relaxation(), {}, context));
  const auto peak =
      static_cast<std::size_t>(std::max_element(c.strain.begin(), c.strain.end()) - c.strain.begin());
  for (const double strain : {0.2, 0.4, 0.5})
    EXPECT_NEAR(tension_at(c, strain) / tension_at(c, strain, peak), 1, 0.02) << strain;
}

TEST(SkinExperiments, TensionRelaxesMonotonicallyForAHundredSeconds) {
  Context context;
  const SkinProperties skin;
  const SkinCurve c = curve_of(relax_skin(skin, 0.2, 100, context));
  const auto peak = static_cast<std::size_t>(std::max_element(c.tension_n_cm.begin(), c.tension_n_cm.end()) -
                                             c.tension_n_cm.begin());
  EXPECT_NEAR(c.time_s[peak], 1, 0.6);
  EXPECT_NEAR(c.time_s.back(), 100, 0.01);
  for (std::size_t i = peak; i + 1 < c.time_s.size(); ++i)
    EXPECT_LT(c.tension_n_cm[i + 1], c.tension_n_cm[i]) << c.time_s[i];
  // Prony: 100 s after the pull 0.12 e^(−100/60) of the slowest part are left.
  const double end = 1 - 0.15 - 0.12 - 0.12 * (1 - std::exp(-99.5 / 60.0));
  EXPECT_NEAR(c.tension_n_cm.back() / elastic_skin_tension(skin, 0.2), end, 0.12)
      << "shear and grips add some";
  const double early = c.tension_n_cm[peak] - tension_at({c.tension_n_cm, c.time_s, c.tension_n_cm}, 20);
  const double late = tension_at({c.tension_n_cm, c.time_s, c.tension_n_cm}, 80) - c.tension_n_cm.back();
  EXPECT_GT(early, 4 * late);
}

TEST(SkinExperiments, StrainCreepsUpAndLevelsUnderALoad) {
  Context context;
  const SkinCurve c = curve_of(creep_skin({}, 0.98, 100, context));
  EXPECT_TRUE(std::is_sorted(c.strain.begin(), c.strain.end()));
  const auto strain_at = [&](double t) {
    return c.strain[static_cast<std::size_t>(std::lower_bound(c.time_s.begin(), c.time_s.end(), t) -
                                             c.time_s.begin())];
  };
  EXPECT_NEAR(c.tension_n_cm.back(), 0.98, 0.01);
  EXPECT_GT(c.strain.back(), strain_at(10) + 0.005);
  EXPECT_GT(strain_at(40) - strain_at(10), 2 * (c.strain.back() - strain_at(70)));
}

TEST(SkinExperiments, CyclesConvergeAsSkinIsPreConditioned) {
  Context context;
  const SkinPull pull{0.5, 0.05, 6, true};
  const SkinCurve c = curve_of(pull_skin({}, pull, context));
  ASSERT_EQ(c.strain.size(), 1201U);
  std::vector<double> peaks;
  for (std::size_t cycle = 0; cycle < 6; ++cycle) {
    const auto begin = c.tension_n_cm.begin() + static_cast<std::ptrdiff_t>(200 * cycle);
    peaks.push_back(*std::max_element(begin, begin + 200));
  }
  for (std::size_t i = 0; i + 1 < peaks.size(); ++i) EXPECT_LT(peaks[i + 1], peaks[i]);
  EXPECT_LT(peaks[4] - peaks[5], 0.5 * (peaks[0] - peaks[1]));
}

TEST(SkinExperiments, RestTensionIsThereAtStrainZeroAndStays) {
  Context context;
  SkinProperties skin;
  skin.rest_tension_n_cm = 0.1;
  const SkinCurve c = curve_of(pull_skin(skin, {0.3, 0.05, 1, false}, context));
  EXPECT_NEAR(c.tension_n_cm.front(), 0.1, 1e-12);
  EXPECT_GT(tension_at(c, 0.1),
            0.1 + tension_at(curve_of(pull_skin({}, {0.3, 0.05, 1, false}, context)), 0.1) - 0.02);
  const SkinCurve held = curve_of(creep_skin(skin, 0.1, 20, context));
  EXPECT_NEAR(held.strain.back(), 0, 0.02) << "a load equal to the rest tension leaves it where it is";
}

TEST(SkinExperiments, WildNumbersAreNamedAndCancellingEndsIt) {
  Context context;
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf, -1.0, 1e308}) {
    for (double SkinProperties::*member :
         {&SkinProperties::lax_n_cm, &SkinProperties::stiff_n_cm, &SkinProperties::anisotropy,
          &SkinProperties::transition_along, &SkinProperties::transition_across,
          &SkinProperties::rest_tension_n_cm, &SkinProperties::shear}) {
      SkinProperties skin;
      skin.*member = bad;
      EXPECT_FALSE(static_cast<bool>(relax_skin(skin, 0.2, 1, context))) << bad;
    }
    SkinProperties skin;
    skin.relaxation[1].share = bad;
    EXPECT_FALSE(static_cast<bool>(relax_skin(skin, 0.2, 1, context))) << bad;
    EXPECT_FALSE(static_cast<bool>(relax_skin({}, bad, 1, context)));
    EXPECT_FALSE(static_cast<bool>(relax_skin({}, 0.2, bad, context)));
    EXPECT_FALSE(static_cast<bool>(creep_skin({}, bad, 1, context)));
    EXPECT_FALSE(static_cast<bool>(pull_skin({}, {bad, 0.02, 1, true}, context)));
    EXPECT_FALSE(static_cast<bool>(pull_skin({}, {0.5, bad, 1, true}, context)));
  }
  EXPECT_FALSE(static_cast<bool>(pull_skin({}, {0.5, 0.02, 1'000'000, true}, context)));
  Context stopped({}, {}, [] { return true; });
  const auto result = relax_skin({}, 0.2, 100, stopped);
  ASSERT_FALSE(static_cast<bool>(result));
  EXPECT_EQ(result.error().kind, ErrorKind::cancelled);
}

}  // namespace
}  // namespace turgor
