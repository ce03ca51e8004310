#include "turgor/world/patient_case.hpp"

#include <fmt/format.h>

#include <utility>

namespace turgor {
namespace {

Result<void> correct_landmarks(const CaseOptions& options, const Box3& scan, Landmarks& landmarks) {
  for (const auto& [name, point] : options.landmark_corrections) {
    if (find_landmark_kind(name) == nullptr) {
      return Error{ErrorKind::bad_command, "there is no landmark '" + name + "'", "plan",
                   "See: turgor help landmark"};
    }
    if (!scan.contains(point)) {
      return Error{ErrorKind::bad_command,
                   fmt::format("the landmark '{}' at ({:g}, {:g}, {:g}) lies outside the scan", name, point.x,
                               point.y, point.z),
                   "plan", "Give millimetres within the extent that turgor info prints"};
    }
    landmarks[name] = {point, true};
  }
  return {};
}

}  // namespace

PatientCase::PatientCase(Scan&& scan, Head&& head)
    : scan_info_(std::move(scan.info)), scan_grid_(scan.hu.grid), head_(std::move(head)), bones_(head_) {}

Result<PatientCase> PatientCase::open(const std::filesystem::path& path, const CaseOptions& options,
                                      Context& context) {
  TURGOR_TRY(Scan scan, read_scan(path, options.scan, context));
  auto built = build_head(scan, options.head, context);
  if (!built) {
    Error error = built.error();
    if (error.where.empty() && error.kind != ErrorKind::cancelled) error.where = path.string();
    return error;
  }
  Head head = *std::move(built);
  if (options.midsagittal) head.midsagittal = *options.midsagittal;
  PatientCase patient(std::move(scan), std::move(head));
  patient.scan_path_ = path;
  patient.options_ = options;
  patient.landmarks_ = find_landmarks(patient.head_, context);
  TURGOR_CHECK(correct_landmarks(options, patient.head_.scan_box, patient.landmarks_));
  TURGOR_TRY(patient.tissue_, build_tissue(patient.head_, patient.landmarks_, options.tissue, context));
  patient.part_lips();
  return patient;
}

void PatientCase::part_lips() {
  skin_ = head_.skin;
  skin_lip_side_.assign(skin_.points.size(), 0);
  if (tissue_.slit) skin_ = turgor::part_lips(head_.skin, *tissue_.slit, 0.25, &skin_lip_side_);
}

int PatientCase::segment_of_column(int column) const {
  const ColumnEnd end = tissue_.ends[static_cast<std::size_t>(column)];
  if (end == ColumnEnd::none) return -1;
  const Vec3& inner = tissue_.points[static_cast<std::size_t>(tissue_.point(tissue_.sheets - 1, column))];
  return bones_.segment_at(end == ColumnEnd::skull ? Bone::skull : Bone::mandible, inner);
}

Result<void> PatientCase::edit_attachment(const AttachmentEdit& edit) {
  const int segment = bones_.find(edit.segment);
  if (segment < 0) {
    return Error{ErrorKind::bad_command, "there is no bone segment '" + edit.segment + "'", "",
                 "Name skull, mandible, or a segment that an osteotomy has made"};
  }
  int changed = 0;
  for (int c = 0; c < tissue_.columns(); ++c) {
    if (segment_of_column(c) != segment) continue;
    const Vec3& inner = tissue_.points[static_cast<std::size_t>(tissue_.point(tissue_.sheets - 1, c))];
    if (edit.box && !edit.box->contains(inner)) continue;
    if (edit.ball && distance(edit.ball->first, inner) > edit.ball->second) continue;
    tissue_.attached[static_cast<std::size_t>(c)] = edit.attach;
    ++changed;
  }
  if (changed == 0) {
    return Error{ErrorKind::bad_command, "no tissue meets '" + edit.segment + "' within that region", "",
                 "Enlarge the region, or leave it out to take the whole segment"};
  }
  return {};
}

}  // namespace turgor
