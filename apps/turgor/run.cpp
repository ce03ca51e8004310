// turgor run: a script of a scene to its end, with pictures, a movie and result.json.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "subcommands.hpp"
#include "turgor/commands/session.hpp"
#include "turgor/core/file.hpp"
#include "turgor/render/annotate.hpp"
#include "turgor/render/scene_pictures.hpp"
#include "turgor/world/flesh_objects.hpp"

namespace turgor {
namespace {

using nlohmann::json;

// The pictures of a run on one sheet, each under its time.
class ContactSheet {
 public:
  void add(Image picture, double time) {
    pictures_.push_back(std::move(picture));
    captions_.push_back(fmt::format("t = {:.4g}", time));
  }
  [[nodiscard]] Result<void> write(const std::filesystem::path& path) const {
    const int columns = std::min(3, static_cast<int>(pictures_.size()));
    return write_png(path, side_by_side(pictures_, captions_, columns));
  }

 private:
  std::vector<Image> pictures_;
  std::vector<std::string> captions_;
};

// Takes pictures, measures and movie frames as time goes by.
class Observer {
 public:
  Observer(const Invocation& arguments, std::filesystem::path folder, Context& context)
      : folder_(std::move(folder)),
        context_(context),
        quiet_(
            {}, [&](const Notice& n) { context.warning(n.text); }, [&] { return context.cancelled(); }),
        times_(arguments.numbers("at")),
        states_(arguments.flag("states")) {
    std::ranges::sort(times_);
    options_.samples = static_cast<int>(arguments.integer("samples"));
    if (arguments.given("movie")) interval_ = arguments.number("movie");
    fps_ = static_cast<int>(arguments.integer("fps"));
    if (arguments.flag("sheet")) sheet_.emplace();
  }

  Result<void> picture(const Scene& scene, const std::filesystem::path& path) {
    TURGOR_TRY(const Image image, draw_screen(scene, options_, quiet_));
    return write_png(path, image);
  }

  Result<void> observe(const Scene& scene) {
    inverted_ = std::max(inverted_, inverted_prisms(scene.specimen));
    for (const Penetration& p : penetrations(scene.specimen)) {
      if (p.radius > 0) depth_ = std::max(depth_, p.depth / p.radius);
    }
    if (history_.empty()) TURGOR_CHECK(record(scene, "start"));
    // Steps add up with round-off: a time counts as reached a little before.
    const double reached = scene.time + 1e-9 * std::max(1.0, std::abs(scene.time));
    for (; next_ < times_.size() && times_[next_] <= reached; ++next_) {
      TURGOR_CHECK(record(scene, fmt::format("t_{:g}", times_[next_])));
    }
    return interval_ > 0 && reached >= next_frame_ ? add_frame(scene, reached) : Result<void>();
  }

  Result<void> finish(const Scene& scene) {
    TURGOR_CHECK(record(scene, "end"));
    if (sheet_) TURGOR_CHECK(sheet_->write(folder_ / "sheet.png"));
    if (!movie_) return {};
    TURGOR_TRY(const bool encoded, movie_->encode(folder_ / "movie.mp4", fps_, context_));
    if (!encoded) context_.notice("ffmpeg is not installed: the movie is left as frames");
    return {};
  }

  [[nodiscard]] json result(const Scene& scene) const {
    return {{"history", history_},
            {"final", json::parse(scene_json(scene))},
            {"most_inverted_prisms", inverted_},
            {"greatest_depth_over_radius", depth_},
            {"movie_frames", movie_ ? movie_->frames() : 0}};
  }

 private:
  Result<void> record(const Scene& scene, const std::string& name) {
    TURGOR_TRY(Image image, draw_screen(scene, options_, quiet_));
    TURGOR_CHECK(write_png(folder_ / (name + ".png"), image));
    if (sheet_) sheet_->add(std::move(image), scene.time);
    if (states_) TURGOR_CHECK(write_state(scene, folder_ / (name + ".state")));
    json entry = json::parse(scene_json(scene));
    entry["picture"] = name + ".png";
    history_.push_back(std::move(entry));
    return {};
  }

  Result<void> add_frame(const Scene& scene, double reached) {
    if (!movie_) {
      TURGOR_TRY(Movie movie, Movie::create(folder_ / "frames"));
      movie_ = std::move(movie);
    }
    // The next multiple; every frame where the interval is lost in the digits of the time.
    const double next = (std::floor(reached / interval_) + 1) * interval_;
    next_frame_ = std::isfinite(next) ? next : reached;
    ScenePictureOptions quick = options_;
    quick.samples = std::min(quick.samples, 4);
    TURGOR_TRY(const Image image, draw_screen(scene, quick, quiet_));
    return movie_->add(image);
  }

  std::filesystem::path folder_;
  Context& context_;
  Context quiet_;
  ScenePictureOptions options_;
  std::vector<double> times_;
  bool states_;
  std::size_t next_ = 0;
  double interval_ = 0, next_frame_ = 0;
  int fps_ = 25, inverted_ = 0;
  double depth_ = 0;
  std::optional<Movie> movie_;
  std::optional<ContactSheet> sheet_;
  std::vector<json> history_;
};

void print_summary(const Scene& scene) {
  for (const FleshMeasures& m : measure(scene.specimen)) {
    fmt::print("{}: time {:g}, {} samples, {} springs, {} of {} prisms inverted", m.name, scene.time,
               m.samples, m.springs, m.inverted, m.prisms);
    if (m.rest_opening > 0)
      fmt::print(", opening {:.1f} % of that at rest", 100 * m.opening / m.rest_opening);
    fmt::print("\n");
  }
}

json record_of(const std::string& command_line, const Result<void>& done, const Context& context,
               double seconds) {
  json out{{"program", std::string("turgor ") + program_version},
           {"command_line", command_line},
           {"seconds", seconds}};
  if (!done) out["error"] = done.error().message();
  json notices = json::array();
  for (const Notice& n : context.notices()) notices.push_back(n.text);
  out["notices"] = std::move(notices);
  return out;
}

Result<void> play(Session& session, Observer& observer, Context& context) {
  const Stage stage(context, "simulating");
  TURGOR_CHECK(session.run());
  return observer.finish(session.scene());
}

// What was written stays, also where the script fails or is interrupted: result.json says so.
Result<void> run_in(const std::filesystem::path& folder, const Invocation& arguments,
                    const std::string& command_line, Context& context) {
  const auto start = std::chrono::steady_clock::now();
  Observer observer(arguments, folder, context);
  SessionOptions options;
  for (const std::string& path : arguments.words("search")) options.search_paths.emplace_back(path);
  options.search_paths.push_back(arguments.path("script").parent_path());
  options.output = folder;
  options.picture = [&](const Scene& scene, const std::filesystem::path& path) {
    return observer.picture(scene, path);
  };
  options.frame = [&](const Scene& scene) { return observer.observe(scene); };
  options.say = [](std::string_view text) { fmt::print("{}\n", text); };
  Session session(std::move(options), context);
  if (arguments.given("size")) {
    const auto& size = arguments.all("size").front().integers;
    TURGOR_CHECK(session.enter_text(fmt::format("screen -size {} {}", size.at(0), size.at(1)), "-size"));
  }
  TURGOR_CHECK(session.enter_script(arguments.path("script")));
  auto done = play(session, observer, context);
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
  json result = record_of(command_line, done, context, spent.count());
  result.update(observer.result(session.scene()));
  TURGOR_CHECK(write_file(folder / "result.json", result.dump(2) + '\n'));
  TURGOR_CHECK(write_file(folder / "recording.turgor", session.recording()));
  if (done) print_summary(session.scene());
  return done;
}

}  // namespace

Result<void> run_script(const Invocation& arguments, const std::string& command_line, Context& context) {
  const std::filesystem::path target = arguments.path("output");
  TURGOR_CHECK(check_output_folder(target));
  TURGOR_TRY(StagedFolder staged, StagedFolder::create(target));
  const auto done = run_in(staged.path(), arguments, command_line, context);
  if (std::filesystem::exists(staged.path() / "result.json")) TURGOR_CHECK(staged.commit());
  if (!done) return staged.as_target(done.error());
  fmt::print("results: {}\n", target.string());
  return {};
}

}  // namespace turgor
