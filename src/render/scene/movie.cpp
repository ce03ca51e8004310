#include <unistd.h>

#include <initializer_list>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "render/scene/child_process.hpp"
#include "turgor/render/scene_pictures.hpp"

namespace turgor {

using namespace render_detail;
namespace fs = std::filesystem;

namespace {

Error bad(std::string what, std::string where, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), std::move(where), std::move(remedy)};
}

/// The pattern that ffmpeg reads the frames by; a per cent sign in a folder's name must not be taken for its
/// own.
std::string frame_pattern(const fs::path& folder) {
  std::string out;
  for (const char c : fs::absolute(folder).string()) out += c == '%' ? "%%" : std::string(1, c);
  return out + "/frame_%04d.png";
}

/// One thread and no dates or versions: the same frames give the same bytes. H.264 in yuv420p needs even
/// sides; an odd picture gets a white line at its right or bottom. The count keeps out what an earlier movie
/// may have left in the folder.
std::vector<std::string> ffmpeg_arguments(const fs::path& frames, int count, const fs::path& file, int rate) {
  const std::string filter =
      "pad=ceil(iw/2)*2:ceil(ih/2)*2:0:0:white,"
      "scale=flags=bicubic+accurate_rnd+bitexact:out_color_matrix=bt709:out_range=tv,format=yuv420p";
  std::vector<std::string> out{"ffmpeg"};
  const auto add = [&](std::initializer_list<std::string> more) { out.insert(out.end(), more); };
  add({"-hide_banner", "-loglevel", "error", "-nostdin", "-y"});
  add({"-framerate", std::to_string(rate), "-start_number", "0", "-i", frame_pattern(frames)});
  add({"-frames:v", std::to_string(count), "-vf", filter});
  add({"-c:v", "libx264", "-preset", "medium", "-crf", "23", "-threads", "1"});
  add({"-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "iec61966-2-1"});
  add({"-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact"});
  add({"-movflags", "+faststart", "-f", "mp4", file.string()});
  return out;
}

}  // namespace

Result<Movie> Movie::create(fs::path folder) {
  std::error_code code;
  fs::create_directories(folder, code);
  if (code || !fs::is_directory(folder, code))
    return Error{ErrorKind::system, "the folder for the movie's frames cannot be made", folder.string(),
                 "Choose another place"};
  Movie movie;
  movie.folder_ = std::move(folder);
  return movie;
}

Result<void> Movie::add(const Image& frame) {
  if (frames_ == 0) width_ = frame.width, height_ = frame.height;
  if (frame.width != width_ || frame.height != height_)
    return bad(fmt::format("frame {} is {} by {} pixels, the first one {} by {}", frames_, frame.width,
                           frame.height, width_, height_),
               folder_.string(), "Keep the screen's size while a movie is made");
  TURGOR_CHECK(write_png(folder_ / fmt::format("frame_{:04}.png", frames_), frame));
  ++frames_;
  return {};
}

Result<bool> Movie::encode(const fs::path& file, int frames_per_second, Context& context) const {
  if (frames_ == 0) return bad("a movie without frames cannot be made", file.string(), "Add frames first");
  if (frames_per_second < 1 || frames_per_second > 1000)
    return bad(fmt::format("{} frames a second are outside 1 to 1000", frames_per_second), file.string(),
               "Use 25 or so");
  const Stage stage(context, "encode movie");
  fs::path partial = fs::absolute(file);
  partial.replace_filename(fmt::format(".{}.{}.part", file.filename().string(), ::getpid()));
  auto ran = run_program(ffmpeg_arguments(folder_, frames_, partial, frames_per_second), context);
  std::error_code code;
  const auto failed = [&](std::string why) {
    fs::remove(partial, code);
    return Error{ErrorKind::system, "the movie could not be written: " + std::move(why), file.string(),
                 "Check the place and its free space; the frames are in " + folder_.string()};
  };
  if (!ran) {
    fs::remove(partial, code);
    return ran.error();
  }
  if (!*ran) return false;
  const ChildResult& result = **ran;
  if (result.exit_code != 0)
    return failed(result.last_complaint.empty() ? fmt::format("ffmpeg ended with code {}", result.exit_code)
                                                : "ffmpeg says '" + result.last_complaint + "'");
  fs::rename(partial, file, code);
  if (code) return failed(code.message());
  return true;
}

}  // namespace turgor
