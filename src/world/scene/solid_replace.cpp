// A solid's mesh exchanged for another while it moves.
#include <fmt/format.h>

#include <algorithm>

#include "turgor/core/index.hpp"
#include "turgor/world/solid_objects.hpp"
#include "world/scene/bad_input.hpp"
#include "world/scene/transforms.hpp"

namespace turgor {
namespace {

// For each old point the new one it is nearest to, by the new tetrahedron that holds it.
Result<std::vector<int>> new_of_old(const SolidPart& part, std::span<const Vec3> now,
                                    std::span<const Vec3> old) {
  TURGOR_TRY(const TetraEmbedding in_new, TetraEmbedding::bind(now, part.mesh.tetrahedra, old));
  std::vector<int> out;
  for (std::size_t i = 0; i < old.size(); ++i) {
    const auto& weights = in_new.places()[i].weights;
    const auto largest = std::max_element(weights.begin(), weights.end()) - weights.begin();
    out.push_back(in_new.corners()[i][static_cast<std::size_t>(largest)]);
  }
  return out;
}

// Held are the new points that the old held ones carry for the larger part.
std::vector<char> held_points(const TetraEmbedding& from_old, const std::vector<char>& was_held) {
  std::vector<char> out;
  for (std::size_t i = 0; i < from_old.places().size(); ++i) {
    double held = 0;
    for (std::size_t k = 0; k < 4; ++k)
      if (was_held[at(from_old.corners()[i][k])] != 0) held += from_old.places()[i].weights[k];
    out.push_back(held > 0.5 ? 1 : 0);
  }
  return out;
}

std::vector<double> carried_stiffness(const SolidMesh& mesh, const TetraEmbedding& from_old,
                                      const std::vector<double>& old) {
  std::vector<double> out;
  for (const auto& t : mesh.tetrahedra) {
    double sum = 0;
    for (const int p : t) sum += 0.25 * old[at(from_old.places()[at(p)].tetrahedron)];
    out.push_back(sum);
  }
  return out;
}

/// Calibrated constants for the new mesh: means, as a mesh without a calibration of its own.
Result<void> carry_constants(const SolidPart& old, const TetraEmbedding& from_old, SolidPart& part) {
  if (old.constants[2].empty()) return {};
  const std::vector<SolidStiffness> was = means_of_tetrahedra(old.elements, old.constants);
  std::array<std::vector<double>, 3> carried;
  constexpr std::array kinds{&SolidStiffness::length, &SolidStiffness::area, &SolidStiffness::volume};
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<double> one(was.size());
    std::transform(was.begin(), was.end(), one.begin(), [&](const SolidStiffness& s) { return s.*kinds[c]; });
    carried[c] = carried_stiffness(part.mesh, from_old, one);
  }
  std::vector<SolidStiffness> now(carried[0].size());
  for (std::size_t t = 0; t < now.size(); ++t) now[t] = {carried[0][t], carried[1][t], carried[2][t]};
  TURGOR_TRY(part.constants, constants_of(part.elements, part.mesh.points, now));
  return refresh_elements(part);
}

}  // namespace

Result<void> Specimen::replace_solid(int body, SolidPart part, const TetraEmbedding& from_old,
                                     const std::function<ObjectTransform(int)>& pose_of) {
  TissueBody& b = bodies_.at(at(body));
  if (!b.solid || from_old.places().size() != part.mesh.points.size())
    return bad_input(fmt::format("the new mesh does not fit '{}'", b.name),
                     "Make it from the solid as it is");
  const std::vector<Vec3> old = positions_of(b);
  const std::span<const Vec3> old_velocity(state_.velocity.data() + b.offset, old.size());
  std::vector<Vec3> now(part.mesh.points.size()), velocity(now.size());
  from_old.apply(old, now);
  from_old.apply(old_velocity, velocity);
  TURGOR_TRY(const std::vector<int> number, new_of_old(part, now, old));
  std::vector<char> was_held;
  for (const char mobile : b.solid->mobile) was_held.push_back(mobile == 0 ? 1 : 0);
  part.mobile.clear();
  for (const char held : held_points(from_old, was_held)) part.mobile.push_back(held == 0 ? 1 : 0);

  for (Attachment& attachment : attachments_) {
    if (attachment.body != body) continue;
    std::vector<char> tied(old.size(), 0);
    for (const int i : attachment.samples) tied[at(i)] = 1;
    const ObjectTransform back = inverse(pose_of(attachment.object));
    attachment.samples.clear();
    attachment.places.clear();
    const std::vector<char> still = held_points(from_old, tied);
    for (std::size_t i = 0; i < still.size(); ++i) {
      if (still[i] == 0) continue;
      attachment.samples.push_back(static_cast<int>(i));
      attachment.places.push_back(back.point(now[i]));
      part.mobile[i] = 0;
    }
  }
  const auto follow = [&](SampleRef& ref) {
    if (ref.body == body) ref.number = number[at(ref.number)];
  };
  for (Fibre& fibre : shocks_) follow(fibre.a), follow(fibre.b);
  for (Muscle& muscle : muscles_) {
    for (Fibre& fibre : muscle.fibres) follow(fibre.a), follow(fibre.b);
  }
  const auto joined = [](const Fibre& fibre) { return fibre.a == fibre.b; };
  std::erase_if(shocks_, joined);
  for (Muscle& muscle : muscles_) std::erase_if(muscle.fibres, joined);
  for (auto& handle : handles_) {
    if (handle) follow(*handle);
  }
  for (NamedGrab& grab : grabs_) {
    if (grab.body != body) continue;
    for (int& sample : grab.samples) sample = number[at(sample)];
    std::sort(grab.samples.begin(), grab.samples.end());
    grab.samples.erase(std::unique(grab.samples.begin(), grab.samples.end()), grab.samples.end());
  }

  const auto exchange = [&](std::vector<Vec3>& all, const std::vector<Vec3>& with) {
    const auto first = all.begin() + b.offset;
    std::vector<Vec3> next(all.begin(), first);
    next.insert(next.end(), with.begin(), with.end());
    next.insert(next.end(), first + b.count, all.end());
    all = std::move(next);
  };
  exchange(state_.position, now);
  exchange(state_.velocity, velocity);
  b.solid = std::move(part);
  renumber();
  return {};
}

Result<RemeshTask> start_remesh(const Scene& scene, const std::string& solid, int resolution, int frames) {
  const int body = scene.specimen.body_number(solid);
  if (body < 0 || !scene.specimen.bodies()[at(body)].solid)
    return bad_input(fmt::format("there is no solid '{}'", solid), "Make it with voxelize");
  const TissueBody& b = scene.specimen.bodies()[at(body)];
  const SolidMesh& mesh = b.solid->mesh;
  RemeshTask task;
  task.solid = solid;
  task.due = scene.frame + frames;
  RemeshSnapshot now;
  now.rest.assign(mesh.points.begin(), mesh.points.end());
  now.positions = scene.specimen.positions_of(b);
  now.tetrahedra.assign(mesh.tetrahedra.begin(), mesh.tetrahedra.end());
  now.skin = task.skin = b.solid->shown(now.positions);
  RemeshOptions options;
  options.voxels = b.solid->options.voxels;
  options.voxels.resolution = resolution;
  TURGOR_CHECK(task.work.start(std::move(now), options));
  return task;
}

Result<void> finish_remesh(Scene& scene, RemeshTask& task) {
  TURGOR_TRY(RemeshedSolid made, task.work.take());
  const int body = scene.specimen.body_number(task.solid);
  if (body < 0 || !scene.specimen.bodies()[at(body)].solid)
    return bad_input(fmt::format("the solid '{}' is gone", task.solid),
                     "Keep it until its new mesh is ready");
  const SolidPart& old = *scene.specimen.bodies()[at(body)].solid;
  SolidPart part;
  part.options = old.options;
  part.mesh = std::move(made.solid);
  part.skin = old.skin;
  part.stiffness = carried_stiffness(part.mesh, made.from_old, old.stiffness);
  TURGOR_CHECK(complete_solid_part(part, made.positions, task.skin));
  TURGOR_CHECK(carry_constants(old, made.from_old, part));
  return scene.specimen.replace_solid(body, std::move(part), made.from_old,
                                      [&](int object) { return scene.pose(object); });
}

}  // namespace turgor
