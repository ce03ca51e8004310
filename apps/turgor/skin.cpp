// turgor skin: the experiments of Pieper (1989), figures 2-1 to 2-5, on a strip of the program's own skin.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "subcommands.hpp"
#include "turgor/core/file.hpp"
#include "turgor/render/plot.hpp"
#include "turgor/world/skin_experiments.hpp"

namespace turgor {
namespace {

constexpr Vec3f kBlue{0.02f, 0.13f, 0.45f}, kRed{0.62f, 0.06f, 0.04f}, kGreen{0.03f, 0.30f, 0.10f},
    kOrange{0.75f, 0.25f, 0.01f}, kViolet{0.25f, 0.05f, 0.40f};
constexpr double kStrain = 0.2, kSeconds = 100, kCreepTension = 0.980665;  // 100 g/cm

SkinProperties properties_of(const Invocation& c) {
  SkinProperties skin;
  skin.lax_n_cm = c.number("lax");
  skin.stiff_n_cm = c.number("stiff");
  skin.anisotropy = c.number("anisotropy");
  skin.transition_along = c.number("transition");
  skin.transition_across = c.number("transition_across");
  skin.langer_deg = c.number("langer");
  skin.rest_tension_n_cm = c.number("rest_tension");
  return skin;
}

// One experiment: its curves, and how they are drawn.
struct Experiment {
  std::string name, title;
  std::vector<std::pair<std::string, SkinCurve>> curves;
  enum class Axes { tension_over_strain, tension_over_time, strain_over_time } axes;
};

// Each cycle as a curve of its own.
std::vector<std::pair<std::string, SkinCurve>> cycles_of(const SkinCurve& whole, int count) {
  std::vector<std::pair<std::string, SkinCurve>> out;
  const std::size_t each = whole.time_s.size() / static_cast<std::size_t>(count);
  for (int cycle = 0; cycle < count; ++cycle) {
    const auto part = [&](const std::vector<double>& v) {
      const auto first = v.begin() + static_cast<std::ptrdiff_t>(each) * cycle;
      return std::vector<double>(first, first + static_cast<std::ptrdiff_t>(each));
    };
    out.emplace_back(fmt::format("cycle {}", cycle + 1),
                     SkinCurve{part(whole.time_s), part(whole.strain), part(whole.tension_n_cm)});
  }
  return out;
}

Result<std::vector<Experiment>> run_experiments(const SkinProperties& skin, Context& context) {
  using Axes = Experiment::Axes;
  SkinPull load;
  load.unloads = false;
  SkinPull cycle, cycles;
  cycle.peak_strain = 0.5;
  cycles.peak_strain = 0.5;
  cycles.cycles = 5;
  cycles.rate_per_s = 0.05;
  SkinProperties along = skin, across = skin;
  along.langer_deg = 0;
  across.langer_deg = 90;
  TURGOR_TRY(SkinCurve j_along, pull_skin(along, load, context));
  TURGOR_TRY(SkinCurve j_across, pull_skin(across, load, context));
  TURGOR_TRY(SkinCurve loop, pull_skin(skin, cycle, context));
  TURGOR_TRY(SkinCurve relaxation, relax_skin(skin, kStrain, kSeconds, context));
  TURGOR_TRY(SkinCurve creep, creep_skin(skin, kCreepTension, kSeconds, context));
  TURGOR_TRY(SkinCurve conditioning, pull_skin(skin, cycles, context));
  return std::vector<Experiment>{
      {"figure_2_1_load",
       "Load (figure 2-1): lax, then stiff",
       {{"along Langer's lines", j_along}, {"across them", j_across}},
       Axes::tension_over_strain},
      {"figure_2_2_hysteresis",
       "Hysteresis (figure 2-2): load above unload",
       {{"", loop}},
       Axes::tension_over_strain},
      {"figure_2_3_stress_relaxation",
       "Stress relaxation (figure 2-3): held at a strain of 0.2",
       {{"", relaxation}},
       Axes::tension_over_time},
      {"figure_2_4_creep", "Creep (figure 2-4): under 100 g/cm", {{"", creep}}, Axes::strain_over_time},
      {"figure_2_5_preconditioning", "Pre-conditioning (figure 2-5): five cycles",
       cycles_of(conditioning, cycles.cycles), Axes::tension_over_strain}};
}

Plot plot_of(const Experiment& experiment) {
  Plot plot;
  plot.title = experiment.title;
  const bool over_time = experiment.axes != Experiment::Axes::tension_over_strain;
  plot.x.title = over_time ? "Time, s" : "Strain";
  plot.y.title = experiment.axes == Experiment::Axes::strain_over_time ? "Strain" : "Tension, N/cm";
  plot.x.low = plot.y.low = 0;
  constexpr std::array colours{kBlue, kRed, kGreen, kOrange, kViolet};
  for (const auto& [name, curve] : experiment.curves) {
    Curve drawn;
    drawn.name = name;
    drawn.colour = colours[plot.curves.size() % colours.size()];
    drawn.x = over_time ? curve.time_s : curve.strain;
    drawn.y = experiment.axes == Experiment::Axes::strain_over_time ? curve.strain : curve.tension_n_cm;
    plot.curves.push_back(std::move(drawn));
  }
  return plot;
}

std::string table_of(const Experiment& experiment) {
  std::string text = "curve,time_s,strain,tension_n_cm\n";
  for (const auto& [name, curve] : experiment.curves) {
    for (std::size_t i = 0; i < curve.time_s.size(); ++i) {
      text += fmt::format("{},{},{},{}\n", name, curve.time_s[i], curve.strain[i], curve.tension_n_cm[i]);
    }
  }
  return text;
}

// Area under tension over strain, N/cm: of a closed loop what is lost in it.
double work(const SkinCurve& curve) {
  double sum = 0;
  for (std::size_t i = 1; i < curve.strain.size(); ++i) {
    sum +=
        0.5 * (curve.tension_n_cm[i] + curve.tension_n_cm[i - 1]) * (curve.strain[i] - curve.strain[i - 1]);
  }
  return sum;
}

nlohmann::json summary_of(const std::vector<Experiment>& all) {
  const auto peak = [](const std::vector<double>& v) { return *std::max_element(v.begin(), v.end()); };
  const SkinCurve &relaxation = all.at(2).curves[0].second, &creep = all.at(3).curves[0].second;
  const double peak_tension = peak(relaxation.tension_n_cm);
  return {{"peak_tension_along_n_cm", peak(all.at(0).curves[0].second.tension_n_cm)},
          {"peak_tension_across_n_cm", peak(all.at(0).curves[1].second.tension_n_cm)},
          {"work_lost_in_a_cycle_n_cm", work(all.at(1).curves[0].second)},
          {"tension_left_after_100_s", relaxation.tension_n_cm.back() / peak_tension},
          {"creep_strain_after_100_s", creep.strain.back()}};
}

}  // namespace

Result<void> run_skin(const Invocation& arguments, Context& context) {
  const std::filesystem::path target = arguments.path("output");
  TURGOR_CHECK(check_output_folder(target));
  std::vector<Experiment> experiments;
  {
    const Stage stage(context, "pulling skin");
    TURGOR_TRY(experiments, run_experiments(properties_of(arguments), context));
  }
  TURGOR_CHECK(write_folder(target, [&](const std::filesystem::path& folder) -> Result<void> {
    for (const Experiment& experiment : experiments) {
      TURGOR_TRY(const Image picture, draw_plot(plot_of(experiment)));
      TURGOR_CHECK(write_png(folder / (experiment.name + ".png"), picture));
      TURGOR_CHECK(write_file(folder / (experiment.name + ".csv"), table_of(experiment)));
    }
    return write_file(folder / "skin.json", summary_of(experiments).dump(2) + '\n');
  }));
  fmt::print("{}\nresults: {}\n", summary_of(experiments).dump(2), target.string());
  return {};
}

}  // namespace turgor
