// Bone after the plan, and free tissue that it meets.
#pragma once

#include <optional>
#include <vector>

#include "turgor/geometry/surface_query.hpp"
#include "turgor/tissue/network.hpp"
#include "turgor/world/patient_case.hpp"

namespace turgor {

/// Whether a segment ends anywhere but where it was.
bool moves(const BoneSegment& segment);

/// Free tissue does not enter bone: lips lie before teeth, the neck before the angle of the jaw. Bone is
/// looked for along the column, from the skin inwards.
class BoneContact {
 public:
  explicit BoneContact(const PatientCase& patient);

  /// Where the inner end of a free column is set upon moved bone that has entered the column; nothing where
  /// none has.
  [[nodiscard]] std::optional<Vec3> pushed(int column) const;
  /// The plane of the bone that an inner end at `end` meets or may soon meet.
  [[nodiscard]] std::optional<Contact> plane(int column, const Vec3& end) const;
  /// How deep `end` lies in bone along its column, mm, beyond what it did before the plan.
  [[nodiscard]] double depth(int column, const Vec3& end) const;

 private:
  // Bone on the line of a column, mm from its skin inwards; negative outside it.
  struct Interval {
    double from, to;
    Vec3 normal;  // where it is entered
  };
  // Surfaces and how to look through them.
  struct Bones {
    std::vector<TriMesh> surfaces;
    std::optional<SurfaceQuery> query;
    void prepare();
    [[nodiscard]] std::vector<Interval> along(const Vec3& skin, const Vec3& inwards, double reach) const;
  };
  struct Column {
    Vec3 skin, inwards;
    double thickness;
  };
  [[nodiscard]] Column column_at_rest(int column) const;
  [[nodiscard]] static std::optional<Interval> at_end(const Bones& bones, const Column& column,
                                                      const Vec3& end);

  const LayeredTissue& tissue_;
  double adhesion_n_mm_;
  Bones moved_, all_;
  std::vector<double> depth_at_rest_;  // of inner ends in bone, by column, mm
};

}  // namespace turgor
