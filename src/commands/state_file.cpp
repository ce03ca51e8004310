// The state of a scene's tissue in files: exactly, to be restored; and as a mesh to look at.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "turgor/commands/session.hpp"
#include "turgor/core/file.hpp"
#include "turgor/geometry/mesh_file.hpp"

namespace turgor {
namespace {

using nlohmann::json;

constexpr const char* kFormat = "turgor state 1";

json rows(const std::vector<Vec3>& values) {
  json out = json::array();
  for (const Vec3& v : values) out.push_back({v.x, v.y, v.z});
  return out;
}

Error damaged(const std::filesystem::path& path, const std::string& what) {
  return {ErrorKind::bad_input, what, path.string(), "Use a file that `state` wrote"};
}

Result<std::vector<Vec3>> read_rows(const json& from, const std::filesystem::path& path) {
  std::vector<Vec3> out;
  if (!from.is_array()) return damaged(path, "a list of numbers is missing");
  for (const json& row : from) {
    const bool sound =
        row.is_array() && row.size() == 3 && row[0].is_number() && row[1].is_number() && row[2].is_number();
    if (!sound) return damaged(path, fmt::format("row {} is not of three numbers", out.size()));
    out.push_back({row[0].get<double>(), row[1].get<double>(), row[2].get<double>()});
  }
  return out;
}

// Prisms between layers, springs as lines, and loose samples' springs.
CellMesh cells_of(const Specimen& specimen) {
  CellMesh mesh;
  mesh.points = specimen.state().position;
  const auto cell = [&](std::uint8_t type, std::initializer_list<int> corners) {
    mesh.connectivity.insert(mesh.connectivity.end(), corners.begin(), corners.end());
    mesh.offsets.push_back(static_cast<int>(mesh.connectivity.size()));
    mesh.types.push_back(type);
  };
  constexpr std::uint8_t line = 3, tetrahedron = 10, wedge = 13;
  for (std::size_t b = 1; b < specimen.bodies().size(); ++b) {
    const TissueBody& body = specimen.bodies()[b];
    if (body.solid) {
      const int o = body.offset;
      for (const auto& t : body.solid->mesh.tetrahedra)
        cell(tetrahedron, {o + t[0], o + t[1], o + t[2], o + t[3]});
      continue;
    }
    for (const Index3& t : triangulated(body.flesh.surface).triangles) {
      for (int layer = 0; layer + 1 < body.flesh.layers; ++layer) {
        const auto at = [&](int l, int c) { return body.offset + body.flesh.sample(l, c); };
        cell(wedge, {at(layer, t[0]), at(layer, t[1]), at(layer, t[2]), at(layer + 1, t[0]),
                     at(layer + 1, t[1]), at(layer + 1, t[2])});
      }
    }
  }
  for (const Fibre& shock : specimen.shocks()) cell(line, {specimen.index(shock.a), specimen.index(shock.b)});
  for (const Muscle& muscle : specimen.muscles()) {
    for (const Fibre& fibre : muscle.fibres) cell(line, {specimen.index(fibre.a), specimen.index(fibre.b)});
  }
  return mesh;
}

MeshField velocities(const Specimen& specimen) {
  MeshField field{"velocity", 3, {}};
  for (const Vec3& v : specimen.state().velocity) {
    const Vec3f f = to_float(v);
    field.values.insert(field.values.end(), {f.x, f.y, f.z});
  }
  return field;
}

}  // namespace

Result<void> write_state(const Scene& scene, const std::filesystem::path& path) {
  const MotionState& state = scene.specimen.state();
  json out{{"format", kFormat},
           {"time", scene.time},
           {"position", rows(state.position)},
           {"velocity", rows(state.velocity)}};
  if (!state.relaxed.empty()) out["relaxed"] = state.relaxed;
  TURGOR_CHECK(write_file(path, out.dump()));
  std::filesystem::path mesh = path;
  return write_vtu(mesh.replace_extension(".vtu"), cells_of(scene.specimen), {velocities(scene.specimen)});
}

Result<void> read_state(Scene& scene, const std::filesystem::path& path) {
  TURGOR_TRY(const std::string text, read_text_file(path, std::uint64_t{4} << 30));
  const json in = json::parse(text, nullptr, false);
  if (in.is_discarded() || !in.is_object() || in.value("format", json()) != kFormat)
    return damaged(path, "this is no state");
  if (!in.contains("time") || !in["time"].is_number()) return damaged(path, "the time is missing");
  MotionState state;
  TURGOR_TRY(state.position, read_rows(in.value("position", json()), path));
  TURGOR_TRY(state.velocity, read_rows(in.value("velocity", json()), path));
  static_assert(kRelaxations == 3);
  TURGOR_TRY(const auto relaxed, read_rows(in.value("relaxed", json::array()), path));
  for (const Vec3& q : relaxed) state.relaxed.push_back({q.x, q.y, q.z});
  const double time = in["time"].get<double>();
  if (!std::isfinite(time)) return damaged(path, "the time is not finite");
  TURGOR_CHECK(scene.specimen.set_state(std::move(state)));
  scene.time = time;
  return {};
}

}  // namespace turgor
