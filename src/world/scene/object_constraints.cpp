#include "turgor/world/object_constraints.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "world/scene/constraint_tools.hpp"
#include "world/scene/polyline.hpp"
#include "world/scene/transforms.hpp"

namespace turgor {

Result<void> move_object(Scene& scene, int id, const ObjectTransform& transform) {
  if (!is_finite(transform)) {
    return Error{ErrorKind::bad_input, "its new place is not finite", scene.find(id)->name,
                 "Bring what it depends on nearer"};
  }
  scene.set_transform(id, transform);
  return {};
}

Result<std::string> add_served(Scene& scene, Constraint constraint) {
  TURGOR_CHECK(constraint.satisfy(scene));
  return scene.constraints.add(std::move(constraint));
}

namespace {

Error bad(std::string what, std::string where, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), std::move(where), std::move(remedy)};
}

// --- links ---------------------------------------------------------------------------------------------

struct Link {
  int link = 0, a = 0, b = 0;
  Vec3 left_end;             ///< middle of the link's left end, in its own coordinates
  double own_length = 1;     ///< along its x axis
  double width_y, width_z;   ///< scales across
  double volume_length = 0;  ///< length at which these widths hold; 0: at every length

  Result<void> operator()(Scene& scene) const {
    const Vec3 from = centre_of(*scene.find(a)), to = centre_of(*scene.find(b));
    const Vec3 along = to - from, x = unit(along);
    const Vec3 across = cross({0, 0, 1}, x);
    const Vec3 y = length(across) < 1e-6 ? any_orthogonal(x == Vec3{} ? Vec3{1, 0, 0} : x) : unit(across);
    const double reach = std::hypot(along.x, along.y, along.z);
    const double thinning = volume_length > 0 && reach > 0 ? std::sqrt(volume_length / reach) : 1;
    const Mat3 linear{{along / own_length, y * (width_y * thinning), cross(x, y) * (width_z * thinning)}};
    const Vec3& origin = scene.find(link)->transform.origin;
    return move_object(scene, link, taking(left_end, from, linear, origin));
  }
};

Result<Link> make_link(const Object& object, bool keep_volume) {
  Object own = object;
  own.transform = {};
  const Box3 box = world_box(own);
  if (box.empty() || !(box.size().x > 0) || !std::isfinite(box.size().x)) {
    return bad("has no length along its own x axis", object.name, "Use 'line' or 'cube' for a link");
  }
  const auto& columns = object.transform.linear.c;
  Link link;
  link.own_length = box.size().x;
  link.left_end = {box.lower.x, box.centre().y, box.centre().z};
  link.width_y = length(columns[1]), link.width_z = length(columns[2]);
  if (keep_volume) link.volume_length = length(columns[0]) * link.own_length;
  return link;
}

// --- hierarchies ---------------------------------------------------------------------------------------

/// Keeps the child's place in the parent's frame. Where somebody else has moved the child since, its new
/// place is the one that is kept.
struct Parenthood {
  int child = 0, parent = 0;
  ObjectTransform parent_then, child_then;  ///< as this constraint left them
  ObjectTransform place;                    ///< of the child in the parent's frame

  Result<void> measure(const ObjectTransform& child_now) {
    const ObjectTransform measured = inverse(parent_then) * child_now;
    if (!is_finite(measured)) return bad("is flat: nothing can keep a place in it", "the parent", "Scale it");
    place = measured;
    child_then = child_now;
    return {};
  }
  Result<void> operator()(Scene& scene) {
    const ObjectTransform parent_now = scene.pose(parent), child_now = scene.find(child)->transform;
    if (!(child_now == child_then)) TURGOR_CHECK(measure(child_now));
    // The same place to the bit as long as the parent stands still.
    if (parent_now == parent_then) return {};
    const ObjectTransform moved = about(child_now.origin, parent_now * place);
    TURGOR_CHECK(move_object(scene, child, moved));
    parent_then = parent_now;
    child_then = moved;
    return {};
  }
};

}  // namespace

Result<std::string> add_link(Scene& scene, const std::string& link, const std::string& a,
                             const std::string& b, bool keep_volume) {
  TURGOR_TRY(const int link_id, scene.require(link));
  TURGOR_TRY(const int a_id, scene.require(a));
  TURGOR_TRY(const int b_id, scene.require(b));
  if (link_id == a_id || link_id == b_id || a_id == b_id) {
    return bad("a link joins two other objects", link, "Name three different objects");
  }
  TURGOR_TRY(Link constraint, make_link(*scene.find(link_id), keep_volume));
  constraint.link = link_id, constraint.a = a_id, constraint.b = b_id;
  return add_served(scene, {.kind = "link",
                            .triggers = {object_node(a_id), object_node(b_id)},
                            .satisfy = constraint,
                            .arguments = link + " " + a + " " + b + (keep_volume ? " -volume" : ""),
                            .changes = {object_node(link_id)}});
}

Result<std::string> add_parent(Scene& scene, const std::string& child, const std::string& parent) {
  TURGOR_TRY(const int child_id, scene.require(child));
  TURGOR_TRY(const int parent_id, scene.require(parent));
  if (child_id == parent_id) return bad("an object cannot be its own parent", child, "Name another parent");
  Parenthood constraint;
  constraint.child = child_id, constraint.parent = parent_id;
  constraint.parent_then = scene.pose(parent_id);
  TURGOR_CHECK(constraint.measure(scene.find(child_id)->transform));
  return add_served(scene, {.kind = "parent",
                            .triggers = {object_node(parent_id)},
                            .satisfy = constraint,
                            .arguments = child + " " + parent,
                            .changes = {object_node(child_id)}});
}

Result<std::string> add_stand_in(Scene& scene, const std::string& object) {
  TURGOR_TRY(const int id, scene.require(object));
  const Object& original = *scene.find(id);
  const Box3 box = world_box(original);
  if (box.empty()) return bad("has no points to put a box around", object, "Choose another object");
  Object stand_in;
  stand_in.name = "box." + object;
  stand_in.optics = original.optics;
  stand_in.description = box_polyhedron(box);
  const std::string box_name = stand_in.name;
  TURGOR_TRY(const int box_id, scene.add_object(std::move(stand_in)));
  scene.set_visible(id, false);
  for (World& world : scene.worlds) {
    std::erase(world.objects, box_name);
    const bool shown = std::find(world.objects.begin(), world.objects.end(), object) != world.objects.end();
    if (shown) world.objects.push_back(box_name);
  }
  return add_served(scene, {.kind = "stand_in",
                            .triggers = {object_node(id)},
                            .satisfy = [id, box_id](Scene& s) -> Result<void> {
                              s.set_description(box_id, box_polyhedron(world_box(*s.find(id))));
                              return {};
                            },
                            .arguments = object,
                            .changes = {object_node(box_id)}});
}

Result<std::string> add_object_path(Scene& scene, const std::string& object, const std::string& path,
                                    const PathOptions& options) {
  TURGOR_TRY(const int id, scene.require(object));
  TURGOR_TRY(const PathMotion motion, make_path_motion(scene, path, options));
  if (id == motion.path) return bad("an object cannot be its own path", object, "Name another path");
  return add_served(scene, {.kind = "mv_obj_path",
                            .triggers = {{Node::Kind::frame_start}, object_node(motion.path)},
                            .satisfy = [id, motion](Scene& s) -> Result<void> {
                              TURGOR_TRY(const Vec3 place, motion.place(s));
                              const Object& moved = *s.find(id);
                              ObjectTransform transform = moved.transform;
                              transform.translation += place - centre_of(moved);
                              return move_object(s, id, transform);
                            },
                            .arguments = object + " " + path,
                            .changes = {object_node(id)}});
}

Result<std::string> add_object_move(Scene& scene, const std::string& object, const MoveBy& move) {
  TURGOR_TRY(const int id, scene.require(object));
  const Vec3 axis = unit(move.axis);
  if (axis == Vec3{} && move.angle_deg != 0) return bad("the axis has no length", object, "Give another one");
  if (move.frames < 1) return bad("it is to move in no frame", object, "Give at least 1");
  const Object& moved = *scene.find(id);
  const Vec3 pivot = move.about ? *move.about : centre_of(moved);
  const ObjectTransform from = moved.transform;
  const int first = scene.frame;
  // From where it was, so that the end is exact.
  const auto step = [id, move, axis, pivot, from, first](Scene& s) -> Result<void> {
    const double part = std::clamp(static_cast<double>(s.frame - first) / move.frames, 0.0, 1.0);
    const double angle = part * move.angle_deg * std::numbers::pi / 180;
    const RigidTransform turn = RigidTransform::rotate_about(pivot, axis, angle);
    ObjectTransform there;
    for (int k = 0; k < 3; ++k) there.linear.c[k] = turn.direction(from.linear.c[k]);
    there.origin = from.origin;
    there.translation = turn.point(from.point(from.origin)) + move.shift * part - from.origin;
    return move_object(s, id, there);
  };
  return add_served(scene, {.kind = "mv_obj_by",
                            .triggers = {{Node::Kind::frame_start}},
                            .satisfy = step,
                            .arguments = object,
                            .changes = {object_node(id)}});
}

}  // namespace turgor
