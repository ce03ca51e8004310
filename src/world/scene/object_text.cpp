// Object files: from an object to text.
#include <fmt/format.h>

#include <iterator>
#include <span>
#include <string_view>
#include <utility>

#include "turgor/world/object_file.hpp"

namespace turgor {
namespace {

/// Numbers in the shortest form that reads back as the same bits.
class ObjectWriter {
 public:
  template <class... Args>
  void line(fmt::format_string<Args...> form, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), form, std::forward<Args>(args)...);
    text_ += '\n';
  }
  template <class T>
  void vector(std::string_view keyword, const VecT<T>& v) {
    line("{} {} {} {}", keyword, v.x, v.y, v.z);
  }
  template <class Range>
  void words(const Range& values) {
    line("{}", fmt::join(values, " "));
  }
  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

void write(ObjectWriter& out, const Polyhedron& polyhedron) {
  out.line("points {}", polyhedron.points.size());
  for (const Vec3& p : polyhedron.points) out.line("{} {} {}", p.x, p.y, p.z);
  out.line("polygons {}", polyhedron.ends.size());
  for (int i = 0; i < polyhedron.polygon_count(); ++i) out.words(polyhedron.polygon(i));
  out.line("lines {}", polyhedron.lines.size());
  for (const Edge& edge : polyhedron.lines) out.words(edge);
}
void write(ObjectWriter& out, const CameraLens& lens) {
  out.line("camera");
  out.line("fov {}", lens.fov_deg);
  out.line("height {}", lens.height);
  out.line("target_distance {}", lens.target_distance);
}
void write(ObjectWriter& out, const Light& light) {
  out.line("light");
  out.vector("colour", light.colour);
  out.line("strength {}", light.strength);
}
void write(ObjectWriter& out, const DepthMap& map) {
  out.line("depth_map {} {}", map.columns, map.rows);
  const auto columns = static_cast<std::size_t>(map.columns);
  for (std::size_t row = 0; row < map.heights.size(); row += columns) {
    out.words(std::span(map.heights).subspan(row, columns));
  }
}

void write(ObjectWriter& out, const ObjectTransform& t) {
  const auto& c = t.linear.c;
  std::string rows;
  for (int i = 0; i < 3; ++i) {
    rows += fmt::format(" {} {} {} {}", c[0][i], c[1][i], c[2][i], t.translation[i]);
  }
  out.line("matrix{}", rows);
  out.vector("origin", t.origin);
}

std::string_view yes_no(bool value) {
  return value ? "yes" : "no";
}

void write(ObjectWriter& out, const Optics& optics) {
  out.line("shading {}", optics.shading == Shading::faceted ? "faceted" : "smooth");
  out.vector("diffuse", optics.diffuse);
  out.vector("highlight", optics.highlight);
  out.line("specular {}", optics.specular);
  if (optics.wire) out.vector("wire", *optics.wire);
  out.line("line_width {}", optics.line_width);
  out.line("curved {}", yes_no(optics.curved));
  out.line("opacity {}", optics.opacity);
}

}  // namespace

std::string object_text(const Object& object) {
  ObjectWriter out;
  if (!object.name.empty()) out.line("name {}", object.name);
  std::visit([&](const auto& description) { write(out, description); }, object.description);
  write(out, object.transform);
  out.line("visible {}", yes_no(object.visible));
  out.line("triangulated {}", yes_no(object.triangulated));
  write(out, object.optics);
  return out.take();
}

}  // namespace turgor
