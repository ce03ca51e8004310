// Object files: from text to an object.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>

#include "turgor/core/nearest.hpp"
#include "turgor/geometry/mesh_file.hpp"
#include "turgor/world/object_file.hpp"
#include "world/scene/name.hpp"
#include "world/scene/transforms.hpp"

namespace turgor {
namespace {

/// Lines that hold something, as words without comments.
class LineReader {
 public:
  explicit LineReader(std::string_view text) : rest_(text) {
    if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);
  }

  bool next() {
    words_.clear();
    while (words_.empty() && !rest_.empty()) {
      const std::size_t end = std::min(rest_.find('\n'), rest_.size());
      content_ = rest_.substr(0, end);
      rest_.remove_prefix(std::min(end + 1, rest_.size()));
      ++line_;
      split();
    }
    return !words_.empty();
  }
  [[nodiscard]] const std::vector<std::string_view>& words() const { return words_; }
  /// What follows the first word, with its blanks.
  [[nodiscard]] std::string_view after_keyword() const {
    return std::string_view(words_[1].data(), words_.back().data() + words_.back().size());
  }
  [[nodiscard]] int line() const { return line_; }

 private:
  void split() {
    constexpr std::string_view blanks = " \t\r\v\f";
    content_ = content_.substr(0, content_.find(';'));
    for (std::size_t at = content_.find_first_not_of(blanks);
         at != std::string_view::npos && content_[at] != '#'; at = content_.find_first_not_of(blanks, at)) {
      const std::size_t end = std::min(content_.find_first_of(blanks, at), content_.size());
      words_.push_back(content_.substr(at, end - at));
      at = end;
    }
  }

  std::string_view rest_, content_;
  std::vector<std::string_view> words_;
  int line_ = 0;
};

template <class Number>
bool read_number(std::string_view word, Number& value) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (code != std::errc{} || end != word.data() + word.size()) return false;
  if constexpr (std::is_floating_point_v<Number>) return std::isfinite(value);
  return true;
}

class ObjectParser {
 public:
  ObjectParser(std::string_view text, const std::string& file_name) : reader_(text), file_(file_name) {}

  Result<Object> run() {
    object_.file = file_;
    object_.name = object_name(file_);
    while (reader_.next()) {
      TURGOR_CHECK(read_keyword());
      TURGOR_CHECK(check_values());
    }
    if (!described_) {
      return Error{ErrorKind::bad_input, "holds no shape, mesh, points, camera, light or depth map", file_,
                   "Say what the object is, as in 'shape cube'"};
    }
    if (const auto valid = validate(object_); !valid) return fault(valid.error().what, valid.error().remedy);
    return std::move(object_);
  }

 private:
  using Read = Result<void> (ObjectParser::*)();
  struct Keyword {
    std::string_view name;
    int values;  // -1: one or more
    Read read;
    std::string_view usage;
  };
  static const std::vector<Keyword>& keywords();

  [[nodiscard]] Error fault(std::string what, std::string remedy = {}) const {
    return {ErrorKind::bad_input, std::move(what), fmt::format("{}:{}", file_, reader_.line()),
            std::move(remedy)};
  }

  Result<void> read_keyword() {
    const std::string_view word = reader_.words()[0];
    const auto& known = keywords();
    const auto found =
        std::find_if(known.begin(), known.end(), [&](const Keyword& k) { return k.name == word; });
    if (found == known.end()) {
      std::vector<std::string_view> names;
      names.reserve(known.size());
      for (const Keyword& keyword : known) names.push_back(keyword.name);
      const std::string_view nearest = nearest_word(word, names);
      return fault(fmt::format("no keyword {}", shown_name(word)),
                   nearest.empty() ? "" : fmt::format("Did you mean {}?", nearest));
    }
    const int given = static_cast<int>(reader_.words().size()) - 1;
    if (found->values >= 0 ? given != found->values : given < 1) return misread(*found);
    keyword_ = &*found;
    return (this->*found->read)();
  }
  [[nodiscard]] Error misread(const Keyword& keyword) const {
    return fault(fmt::format("{} cannot be read", shown_name(keyword.name)),
                 fmt::format("Write: {}", keyword.usage));
  }

  /// Ranges, as far as they do not need the whole object.
  [[nodiscard]] Result<void> check_values() const {
    Object part;
    part.transform = object_.transform, part.optics = object_.optics;
    const ObjectKind kind = object_.kind();
    if (kind == ObjectKind::camera || kind == ObjectKind::light) part.description = object_.description;
    const auto valid = validate(part);
    return valid ? Result<void>() : fault(valid.error().what, valid.error().remedy);
  }

  // The words from `first` on as numbers.
  template <class Number, std::size_t n>
  Result<void> take(std::array<Number, n>& values, std::size_t first = 1) const {
    for (std::size_t i = 0; i < n; ++i) {
      if (!read_number(reader_.words()[first + i], values[i])) return misread(*keyword_);
    }
    return {};
  }
  Result<void> take(double& value) const {
    std::array<double, 1> one{};
    TURGOR_CHECK(take(one));
    value = one[0];
    return {};
  }
  Result<void> take(Vec3& value) const {
    std::array<double, 3> v{};
    TURGOR_CHECK(take(v));
    value = {v[0], v[1], v[2]};
    return {};
  }
  Result<void> take(Vec3f& value) const {
    std::array<float, 3> v{};
    TURGOR_CHECK(take(v));
    value = {v[0], v[1], v[2]};
    return {};
  }
  Result<void> take(bool& value) const {
    const std::string_view word = reader_.words()[1];
    if (word != "yes" && word != "no") return misread(*keyword_);
    value = word == "yes";
    return {};
  }

  // --- what the object is ---

  Result<void> describe(Description description) {
    if (described_) return fault("says a second time what the object is", "Keep one description");
    described_ = true;
    object_.description = std::move(description);
    return {};
  }
  template <class Kind>
  Result<Kind*> description() {
    Kind* const found = described_ ? std::get_if<Kind>(&object_.description) : nullptr;
    if (found != nullptr) return found;
    return fault(fmt::format("{} comes without what it belongs to", shown_name(keyword_->name)),
                 fmt::format("Write: {}", keyword_->usage));
  }

  Result<void> shape() {
    auto primitive = make_primitive(std::string(reader_.words()[1]));
    if (!primitive) return fault(primitive.error().what, primitive.error().remedy);
    return describe(std::move(primitive->description));
  }
  Result<void> mesh() {
    const std::filesystem::path path =
        std::filesystem::path(file_).parent_path() / std::filesystem::path(reader_.after_keyword());
    auto surface = read_mesh(path);
    if (!surface) return fault(surface.error().message());
    return describe(to_polyhedron(*surface));
  }

  /// `read(words)` for each of the `count` lines of a block.
  template <class ReadLine>
  Result<void> block(int count, ReadLine&& read) {
    for (int i = 0; i < count; ++i) {
      if (!reader_.next()) {
        return fault(
            fmt::format("ends after {} of the {} lines of {}", i, count, shown_name(keyword_->name)));
      }
      TURGOR_CHECK(read(reader_.words()));
    }
    return {};
  }
  [[nodiscard]] Result<int> count() const {
    std::array<int, 1> value{};
    TURGOR_CHECK(take(value));
    if (value[0] < 0) return misread(*keyword_);
    return value[0];
  }

  Result<void> points() {
    TURGOR_TRY(const int n, count());
    std::vector<Vec3> points;
    TURGOR_CHECK(block(n, [&](const auto& words) -> Result<void> {
      std::array<double, 3> p{};
      if (words.size() != 3) return fault("a point needs three numbers");
      for (std::size_t k = 0; k < 3; ++k) {
        if (!read_number(words[k], p[k]))
          return fault(fmt::format("{} is not a finite number", shown_name(words[k])));
      }
      points.push_back({p[0], p[1], p[2]});
      return {};
    }));
    Polyhedron polyhedron;
    polyhedron.points = std::move(points);
    return describe(std::move(polyhedron));
  }
  /// The numbers of a polygon or line, each of a point and no two the same.
  Result<void> corners(const std::vector<std::string_view>& words, std::size_t points,
                       std::vector<int>& out) {
    out.clear();
    for (const std::string_view word : words) {
      int corner = 0;
      if (!read_number(word, corner) || corner < 0 || static_cast<std::size_t>(corner) >= points) {
        return fault(fmt::format("{} is not the number of a point", shown_name(word)),
                     fmt::format("Points are numbered from 0, {} of them", points));
      }
      out.push_back(corner);
    }
    std::vector<int> sorted = out;
    std::sort(sorted.begin(), sorted.end());
    if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) return fault("names a point twice");
    return {};
  }
  Result<void> polygons() {
    TURGOR_TRY(Polyhedron * polyhedron, description<Polyhedron>());
    TURGOR_TRY(const int n, count());
    std::vector<int> polygon;
    return block(n, [&](const auto& words) -> Result<void> {
      if (words.size() < 3) return fault("a polygon needs three corners or more");
      TURGOR_CHECK(corners(words, polyhedron->points.size(), polygon));
      polyhedron->add_polygon(polygon);
      return {};
    });
  }
  Result<void> lines() {
    TURGOR_TRY(Polyhedron * polyhedron, description<Polyhedron>());
    TURGOR_TRY(const int n, count());
    std::vector<int> ends;
    return block(n, [&](const auto& words) -> Result<void> {
      if (words.size() != 2) return fault("a line has two ends");
      TURGOR_CHECK(corners(words, polyhedron->points.size(), ends));
      polyhedron->lines.push_back({ends[0], ends[1]});
      return {};
    });
  }

  Result<void> camera() { return describe(CameraLens{}); }
  Result<void> fov() {
    TURGOR_TRY(CameraLens * lens, description<CameraLens>());
    return take(lens->fov_deg);
  }
  Result<void> height() {
    TURGOR_TRY(CameraLens * lens, description<CameraLens>());
    return take(lens->height);
  }
  Result<void> target_distance() {
    TURGOR_TRY(CameraLens * lens, description<CameraLens>());
    return take(lens->target_distance);
  }
  Result<void> light() { return describe(Light{}); }
  Result<void> colour() {
    TURGOR_TRY(Light * light, description<Light>());
    return take(light->colour);
  }
  Result<void> strength() {
    TURGOR_TRY(Light * light, description<Light>());
    return take(light->strength);
  }
  Result<void> depth_map() {
    std::array<int, 2> size{};
    TURGOR_CHECK(take(size));
    if (size[0] < 2 || size[1] < 2) return fault("a depth map needs two columns and two rows or more");
    DepthMap map{size[0], size[1], {}};
    TURGOR_CHECK(block(map.rows, [&](const auto& words) -> Result<void> {
      if (words.size() != static_cast<std::size_t>(map.columns)) {
        return fault(fmt::format("a row of {} heights, not {}", words.size(), map.columns));
      }
      for (const std::string_view word : words) {
        double height = 0;
        if (!read_number(word, height))
          return fault(fmt::format("{} is not a finite number", shown_name(word)));
        map.heights.push_back(height);
      }
      return {};
    }));
    return describe(std::move(map));
  }

  // --- where it is ---

  Result<void> matrix() {
    std::array<double, 12> m{};
    TURGOR_CHECK(take(m));
    auto& c = object_.transform.linear.c;
    for (std::size_t k = 0; k < 3; ++k) c[k] = {m[k], m[k + 4], m[k + 8]};
    object_.transform.translation = {m[3], m[7], m[11]};
    return {};
  }
  Result<void> translate() {
    Vec3 by;
    TURGOR_CHECK(take(by));
    object_.transform.translation += by;
    return {};
  }
  Result<void> rotate() {
    Vec3 angles;
    TURGOR_CHECK(take(angles));
    object_.transform.linear = rotation_xyz(angles) * object_.transform.linear;
    return {};
  }
  Result<void> scale() {
    Vec3 s;
    TURGOR_CHECK(take(s));
    object_.transform.linear = Mat3{{Vec3{s.x, 0, 0}, {0, s.y, 0}, {0, 0, s.z}}} * object_.transform.linear;
    return {};
  }
  Result<void> origin() { return take(object_.transform.origin); }

  // --- what it looks like ---

  Result<void> name() {
    const std::string_view word = reader_.words()[1];
    if (const auto valid = check_name(word); !valid) return fault(valid.error().what, valid.error().remedy);
    object_.name = word;
    return {};
  }
  Result<void> visible() { return take(object_.visible); }
  Result<void> triangulated() { return take(object_.triangulated); }
  Result<void> shading() {
    const std::string_view word = reader_.words()[1];
    if (word != "faceted" && word != "smooth") return misread(*keyword_);
    object_.optics.shading = word == "faceted" ? Shading::faceted : Shading::smooth;
    return {};
  }
  Result<void> diffuse() { return take(object_.optics.diffuse); }
  Result<void> highlight() { return take(object_.optics.highlight); }
  Result<void> specular() { return take(object_.optics.specular); }
  Result<void> wire() { return take(object_.optics.wire.emplace()); }
  Result<void> line_width() { return take(object_.optics.line_width); }
  Result<void> curved() { return take(object_.optics.curved); }
  Result<void> opacity() { return take(object_.optics.opacity); }

  LineReader reader_;
  const std::string& file_;
  Object object_;
  bool described_ = false;
  const Keyword* keyword_ = nullptr;
};

const std::vector<ObjectParser::Keyword>& ObjectParser::keywords() {
  using P = ObjectParser;
  static const std::vector<Keyword> table{
      {"name", 1, &P::name, "name NAME"},
      {"shape", 1, &P::shape, "shape PRIMITIVE"},
      {"mesh", -1, &P::mesh, "mesh FILE"},
      {"points", 1, &P::points, "points COUNT, then COUNT lines of x y z"},
      {"polygons", 1, &P::polygons, "polygons COUNT, after the points, then COUNT lines of point numbers"},
      {"lines", 1, &P::lines, "lines COUNT, after the points, then COUNT lines of two point numbers"},
      {"camera", 0, &P::camera, "camera"},
      {"fov", 1, &P::fov, "fov DEGREES, after 'camera'"},
      {"height", 1, &P::height, "height LENGTH, after 'camera'"},
      {"target_distance", 1, &P::target_distance, "target_distance LENGTH, after 'camera'"},
      {"light", 0, &P::light, "light"},
      {"colour", 3, &P::colour, "colour RED GREEN BLUE, after 'light'"},
      {"strength", 1, &P::strength, "strength NUMBER, after 'light'"},
      {"depth_map", 2, &P::depth_map, "depth_map COLUMNS ROWS, then ROWS lines of COLUMNS heights"},
      {"matrix", 12, &P::matrix, "matrix, then the three rows of a 3 × 4 matrix"},
      {"translate", 3, &P::translate, "translate X Y Z"},
      {"rotate", 3, &P::rotate, "rotate X Y Z, in degrees"},
      {"scale", 3, &P::scale, "scale X Y Z"},
      {"origin", 3, &P::origin, "origin X Y Z"},
      {"visible", 1, &P::visible, "visible yes|no"},
      {"triangulated", 1, &P::triangulated, "triangulated yes|no"},
      {"shading", 1, &P::shading, "shading faceted|smooth"},
      {"diffuse", 3, &P::diffuse, "diffuse RED GREEN BLUE"},
      {"highlight", 3, &P::highlight, "highlight RED GREEN BLUE"},
      {"specular", 1, &P::specular, "specular EXPONENT"},
      {"wire", 3, &P::wire, "wire RED GREEN BLUE"},
      {"line_width", 1, &P::line_width, "line_width FACTOR, above 0"},
      {"curved", 1, &P::curved, "curved yes|no"},
      {"opacity", 1, &P::opacity, "opacity NUMBER, 0 to 1"},
  };
  return table;
}

}  // namespace

Result<Object> parse_object(std::string_view text, const std::string& file_name) {
  if (text.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    return Error{ErrorKind::bad_input, "is too large for an object (2 GiB at most)", file_name, "Part it"};
  }
  return ObjectParser(text, file_name).run();
}

}  // namespace turgor
