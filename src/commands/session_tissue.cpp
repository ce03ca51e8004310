// What the commands about tissue, forces, muscles and motion do.
#include <fmt/format.h>

#include <charconv>

#include "session_state.hpp"
#include "turgor/core/file.hpp"
#include "turgor/world/flesh_objects.hpp"
#include "values.hpp"

namespace turgor::commands {
namespace {

SpringOptions spring_options(const Invocation& c) {
  return {c.number("c"), law_named(c.word("m")), c.number("v"), c.number("cutoff")};
}

// ---- flesh_out ----

Result<std::vector<double>> read_map(const std::string& file) {
  TURGOR_TRY(std::vector<double> values, read_numbers(file));
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] > 0 && values[i] < 1e6) continue;
    return Error{ErrorKind::bad_input,
                 fmt::format("number {}, {}, is no factor of a thickness", i + 1, values[i]), file,
                 "Give one number above 0 for each vertex"};
  }
  return values;
}

Result<std::vector<std::vector<double>>> thicknesses(const Invocation& c) {
  const std::vector<double> numbers =
      c.given("thickness") ? c.numbers("thickness") : std::vector{c.number("dfth"), c.number("sfth")};
  const std::vector<std::string> maps = c.words("map");
  if (maps.size() > numbers.size()) {
    return c.error(fmt::format("{} maps are given for {} thicknesses", maps.size(), numbers.size()),
                   "Give one for each", "map");
  }
  std::vector<std::vector<double>> out;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    out.push_back({numbers[i]});
    if (i >= maps.size()) continue;
    TURGOR_TRY(out.back(), read_map(maps[i]));
    for (double& value : out.back()) value *= numbers[i];
  }
  return out;
}

Result<void> flesh_out(SessionState& s, const Invocation& c) {
  FleshOptions options;
  TURGOR_TRY(options.thickness, thicknesses(c));
  options.mass_g = c.number("me");
  options.stiffness_n = c.number("sc");
  options.law = law_named(c.word("m"));
  options.fix_bone = c.flag("fix_bone");
  TURGOR_TRY(const int id, s.scene.require(c.word("object")));
  if (!c.flag("springs_only")) {
    options.volume_modulus_mpa =
        c.given("volume") ? c.number("volume")
                          : default_volume_modulus(world_polyhedron(*s.scene.find(id)), options.stiffness_n);
    options.inversion_guard_mpa =
        c.given("guard") ? c.number("guard") : kGuardShare * options.volume_modulus_mpa;
  }
  return flesh_out_object(s.scene, c.word("object"), options, c.number("v"));
}

// ---- samples and springs by hand ----

Result<void> blot(SessionState& s, const Invocation& c) {
  const Vec3 place = triple(c, "at");
  TURGOR_TRY([[maybe_unused]] const SampleRef made,
             s.scene.specimen.add_sample(c.word("sample"), place, c.number("mass"), !c.flag("fixed")));
  return {};
}

Result<void> shock(SessionState& s, const Invocation& c) {
  TURGOR_TRY(const SampleRef a, find_sample(s.scene, c.word("from")));
  TURGOR_TRY(const SampleRef b, find_sample(s.scene, c.word("to")));
  return s.scene.specimen.add_shock(a, b, spring_options(c));
}

// ---- forces ----

Result<void> gravity(SessionState& s, const Invocation& c) {
  const Vec3 towards = normalized(triple(c, "towards"));
  if (!(squared_length(towards) > 0))
    return c.error("the direction of gravity has no length", "Give another one", "towards");
  return s.scene.specimen.set_gravity(towards * c.number("g"));
}

Result<void> collide(SessionState& s, const Invocation& c, bool clings) {
  Collision collision;
  std::string object;
  constexpr std::array<std::pair<const char*, RegionShape>, 4> shapes{{{"s", RegionShape::sphere},
                                                                       {"p", RegionShape::plane},
                                                                       {"d", RegionShape::depth_map},
                                                                       {"b", RegionShape::mesh}}};
  for (const auto& [flag, shape] : shapes) {
    if (c.given(flag)) object = c.word(flag), collision.shape = shape;
  }
  TURGOR_TRY(collision.object, s.scene.require(object));
  TURGOR_TRY(collision.barrier, barrier_of(s.scene, collision.object, collision.shape));
  collision.placed = s.scene.find(collision.object)->transform;
  collision.barrier.stiffness_n = c.number("c");
  collision.barrier.law = law_named(c.word("m"));
  collision.barrier.clings = clings;
  collision.barrier.threshold_mm = c.number("threshold");
  collision.barrier.reach_mm = c.number("distance");
  collision.layer = static_cast<int>(c.integer("layer"));
  if (c.given("flesh")) {
    collision.body = s.scene.specimen.body_number(c.word("flesh"));
    if (collision.body < 0)
      return c.error(fmt::format("there is no flesh '{}'", c.word("flesh")), "Build it with flesh_out",
                     "flesh");
  } else if (collision.layer >= 0) {
    collision.body = static_cast<int>(s.scene.specimen.bodies().size()) - 1;
    if (collision.body == 0)
      return c.error("a layer is named, but there is no tissue yet", "Build it with flesh_out first",
                     "layer");
  }
  if (collision.layer >= 0) {
    const TissueBody& body = s.scene.specimen.bodies()[static_cast<std::size_t>(collision.body)];
    if (body.solid) return c.error(fmt::format("'{}' is a solid", body.name), "It has no layers", "layer");
    if (collision.layer >= body.flesh.layers) {
      return c.error(fmt::format("'{}' has no layer {}", body.name, collision.layer),
                     fmt::format("Its layers are 0 to {}", body.flesh.layers - 1), "layer");
    }
  }
  return s.scene.specimen.add_collision(std::move(collision));
}
Result<void> drape(SessionState& s, const Invocation& c) {
  return collide(s, c, false);
}
Result<void> cling(SessionState& s, const Invocation& c) {
  return collide(s, c, true);
}

Result<void> damping(SessionState& s, const Invocation& c) {
  return s.scene.specimen.set_damping(c.number("constant"));
}

// ---- muscles ----

// By number and layer, of one flesh.
Result<SampleRef> indexed(const Specimen& specimen, const Invocation& c, int body, std::int64_t number,
                          std::int64_t layer) {
  const TissueBody& named = specimen.bodies()[static_cast<std::size_t>(body)];
  const Flesh& flesh = named.flesh;
  if (named.solid) {
    if (number < named.count) return SampleRef{body, static_cast<int>(number)};
    return c.error(fmt::format("there is no sample {}", number),
                   fmt::format("'{}' has the samples 0 to {}", named.name, named.count - 1), "samples");
  }
  if (number >= flesh.columns() || layer >= flesh.layers) {
    return c.error(fmt::format("there is no sample {} in layer {}", number, layer),
                   fmt::format("'{}' has the samples 0 to {} in the layers 0 to {}", named.name,
                               flesh.columns() - 1, flesh.layers - 1),
                   "samples");
  }
  return SampleRef{body, flesh.sample(static_cast<int>(layer), static_cast<int>(number))};
}

// Its drawing is there at once, for the commands that follow.
Result<void> add_fibre(SessionState& s, const Invocation& c, SampleRef a, SampleRef b) {
  TURGOR_CHECK(s.scene.specimen.add_fibre(c.word("muscle"), a, b, spring_options(c)));
  return update_muscle_objects(s.scene);
}

Result<void> add_muscle(SessionState& s, const Invocation& c) {
  Specimen& specimen = s.scene.specimen;
  if (c.given("near") == c.given("samples")) {
    return c.error("a fibre needs two samples", "Give their numbers and layers, or two points with -near");
  }
  if (c.given("near")) {
    const auto n = c.numbers("near");
    TURGOR_TRY(const SampleRef a, specimen.nearest_sample({n.at(0), n.at(1), n.at(2)}));
    TURGOR_TRY(const SampleRef b, specimen.nearest_sample({n.at(3), n.at(4), n.at(5)}));
    return add_fibre(s, c, a, b);
  }
  const int body = c.given("flesh") ? specimen.body_number(c.word("flesh"))
                                    : static_cast<int>(specimen.bodies().size()) - 1;
  if (body <= 0) return c.error("there is no such tissue yet", "Build it with flesh_out first");
  const auto& n = c.all("samples").front().integers;
  const auto layer = [&](std::size_t i) { return n.size() > i ? n[i] : std::int64_t{1}; };
  TURGOR_TRY(const SampleRef a, indexed(specimen, c, body, n.at(0), layer(2)));
  TURGOR_TRY(const SampleRef b, indexed(specimen, c, body, n.at(1), layer(3)));
  return add_fibre(s, c, a, b);
}

Result<void> twitch(SessionState& s, const Invocation& c) {
  const std::vector<double> keys = c.numbers("keys");
  if (keys.size() % 2 != 0)
    return c.error("the last time has no scale", "Give pairs of time and scale", "keys");
  Twitch twitch;
  twitch.start = c.given("start") ? c.number("start") : s.scene.time;
  for (std::size_t i = 0; i < keys.size(); i += 2) {
    twitch.times.push_back(keys[i]);
    twitch.scales.push_back(keys[i + 1]);
  }
  return s.scene.specimen.set_twitch(c.word("muscle"), std::move(twitch));
}

Result<void> muscle_set(SessionState& s, const Invocation& c) {
  const auto value = [&](const char* name) {
    return c.given(name) ? std::optional(c.number(name)) : std::nullopt;
  };
  TURGOR_TRY(const bool had_effect,
             s.scene.specimen.set_muscle(c.word("muscle"), value("length"), value("scale")));
  if (!had_effect)
    s.context.notice(fmt::format("{}: '{}' twitches: no effect", c.place().text(), c.word("muscle")));
  return {};
}

// ---- motion ----

// Steps that are lost in the round-off of the time would never bring it to its end.
Result<void> check_length(const Invocation& c, const Simulation& run, double time) {
  constexpr double most_steps = 1e12;
  const double dt = run.options.dt;
  if (!run.until || run.left >= 0 || (*run.until - time) / dt <= most_steps) return {};
  return c.error(
      fmt::format("more than {:g} steps of {:g} lie before the time {:g}", most_steps, dt, *run.until),
      "Give a longer -dt, or an earlier end", "dt");
}

Result<void> simulate(SessionState& s, const Invocation& c) {
  if (s.simulation) return c.error("a simulation runs already", "Wait for its end, or interrupt it");
  const bool endless = !c.given("until") && (!c.given("count") || c.integer("count") < 0);
  if (endless && !s.options.interactive) {
    return c.error("the simulation would never end", "Give a number of steps, or -until");
  }
  Simulation run;
  run.options.dt = c.number("dt");
  run.options.integrator = c.flag("runge_kutta") ? Integrator::heun
                           : c.flag("verlet")    ? Integrator::verlet
                                                 : Integrator::euler;
  run.options.implicit = c.flag("implicit");
  if (c.given("adaptive")) run.options.tolerance = c.number("adaptive");
  if (c.given("count")) run.left = c.integer("count");
  if (c.given("until")) run.until = c.number("until");
  TURGOR_CHECK(check_length(c, run, s.scene.time));
  run.skip = c.integer("skip");
  run.resumes = c.flag("resume");
  run.began = s.scene.time;
  run.place = c.place();
  if (!run.is_over(s.scene.time)) s.simulation = run;
  return {};
}

Result<void> frame(SessionState& s, const Invocation& c) {
  s.pause = c.integer("count");
  return {};
}

}  // namespace

Result<std::vector<double>> read_numbers(const std::string& file) {
  TURGOR_TRY(const std::string text, read_text_file(file));
  std::vector<double> values;
  const char* at = text.data();
  const char* const end = at + text.size();
  for (int line = 1; at != end;) {
    if (*at == '\n') ++line;
    if (*at == ' ' || *at == '\t' || *at == '\r' || *at == '\n' || *at == ',') {
      ++at;
      continue;
    }
    double value = 0;
    const auto read = std::from_chars(at, end, value);
    if (read.ec != std::errc() || !(std::abs(value) <= kFarthestMm)) {
      return Error{ErrorKind::bad_input, "not a number", fmt::format("{}:{}", file, line),
                   "Give numbers parted by blanks, commas or lines"};
    }
    values.push_back(value);
    at = read.ptr;
  }
  return values;
}

Result<SampleRef> find_sample(const Scene& scene, const std::string& text) {
  if (const auto by_name = scene.specimen.sample(text)) return *by_name;
  const auto read = [](std::string_view digits, int& value) {
    const char* const end = digits.data() + digits.size();
    const auto [stop, code] = std::from_chars(digits.data(), end, value);
    return stop == end && code == std::errc() && value >= 0;
  };
  const auto& bodies = scene.specimen.bodies();
  for (int b = 1; b < static_cast<int>(bodies.size()); ++b) {
    const TissueBody& body = bodies[static_cast<std::size_t>(b)];
    if (!text.starts_with(body.name + ":")) continue;
    const std::string_view rest = std::string_view(text).substr(body.name.size() + 1);
    const std::size_t colon = rest.find(':');
    int layer = 0, number = 0;
    if (body.solid) {
      if (read(rest, number) && number < body.count) return SampleRef{b, number};
    } else if (colon != std::string_view::npos && read(rest.substr(0, colon), layer) &&
               read(rest.substr(colon + 1), number) && layer < body.flesh.layers &&
               number < body.flesh.columns()) {
      return SampleRef{b, body.flesh.sample(layer, number)};
    }
  }
  return Error{ErrorKind::bad_input, fmt::format("there is no point sample '{}'", text), "",
               "Give the name of one made by blot, FLESH:LAYER:NUMBER or SOLID:NUMBER"};
}

std::span<const NamedHandler> tissue_handlers() {
  static constexpr NamedHandler table[] = {{"flesh_out", flesh_out},
                                           {"blot", blot},
                                           {"shock", shock},
                                           {"gravity_face", gravity},
                                           {"gravity", gravity},
                                           {"drape", drape},
                                           {"cling", cling},
                                           {"damping", damping},
                                           {"add_muscle", add_muscle},
                                           {"setup twitch", twitch},
                                           {"muscle_set", muscle_set},
                                           {"simulate", simulate},
                                           {"frame", frame}};
  return table;
}

}  // namespace turgor::commands
