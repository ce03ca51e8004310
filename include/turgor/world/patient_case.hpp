// One patient: scan, head, tissue and the bones under a plan.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "turgor/anatomy/head.hpp"
#include "turgor/anatomy/layered_tissue.hpp"
#include "turgor/anatomy/tissue_network.hpp"
#include "turgor/core/context.hpp"
#include "turgor/imaging/scan.hpp"
#include "turgor/surgery/bone_plan.hpp"

namespace turgor {

/// How tissue parts from bone and slides on it.
struct ContactOptions {
  /// Tissue this near to bone that moves differently is taken off the bone, mm: the surgeon undermines both
  /// sides of an osteotomy.
  double undermining_mm = 10.0;
  /// Mucosa that slides on bone is drawn back to it with this force per column and millimetre of gap, N/mm:
  /// no air comes between them while the mouth is closed. A column takes some 20 mm², so 0.1 N/mm is 5 kPa at
  /// 1 mm.
  double adhesion_n_mm = 0.1;
};

/// Every choice made between the scan and the model; all have defaults, so a case needs only a path.
struct CaseOptions {
  ReadScanOptions scan;
  HeadOptions head;
  TissueOptions tissue;
  TissueMaterial material;
  ContactOptions contact;
  std::optional<Plane> midsagittal;  ///< correction, normal to the patient's left
  std::vector<std::pair<std::string, Vec3>> landmark_corrections;  ///< by name, mm LPS
};

/// Tissue taken off a bone, or put back on it, within a box or a ball (both empty: everywhere on that bone).
struct AttachmentEdit {
  bool attach = false;
  std::string segment;
  std::optional<Box3> box;
  std::optional<std::pair<Vec3, double>> ball;  ///< centre and radius, mm
};

/// The model of one patient before surgery, and the plan so far.
class PatientCase {
 public:
  /// Reads the scan and builds head, landmarks and tissue. Errors as read_scan, build_head and build_tissue.
  static Result<PatientCase> open(const std::filesystem::path& scan, const CaseOptions& options,
                                  Context& context);

  [[nodiscard]] const std::filesystem::path& scan_path() const { return scan_path_; }
  [[nodiscard]] const CaseOptions& options() const { return options_; }
  [[nodiscard]] const ScanInfo& scan_info() const { return scan_info_; }
  [[nodiscard]] const Grid& scan_grid() const { return scan_grid_; }
  [[nodiscard]] const Head& head() const { return head_; }
  [[nodiscard]] const Landmarks& landmarks() const { return landmarks_; }
  [[nodiscard]] const LayeredTissue& tissue() const { return tissue_; }
  /// The skin as it is shown and written: full resolution, parted at the mouth.
  [[nodiscard]] const TriMesh& skin() const { return skin_; }
  /// Per point of skin(): +1 / −1 on the upper / lower rim of the mouth, else 0.
  [[nodiscard]] const std::vector<int>& skin_lip_side() const { return skin_lip_side_; }

  [[nodiscard]] const BonePlan& bones() const { return bones_; }
  [[nodiscard]] BonePlan& bones() { return bones_; }
  /// Error: unknown segment, no column within the region.
  Result<void> edit_attachment(const AttachmentEdit& edit);

  /// Segment of bones() that holds the inner end of a column; -1 where it met no bone.
  [[nodiscard]] int segment_of_column(int column) const;

 private:
  PatientCase(Scan&& scan, Head&& head);
  void part_lips();

  std::filesystem::path scan_path_;
  CaseOptions options_;
  ScanInfo scan_info_;
  Grid scan_grid_;
  Head head_;
  Landmarks landmarks_;
  LayeredTissue tissue_;
  TriMesh skin_;
  std::vector<int> skin_lip_side_;
  BonePlan bones_;
};

}  // namespace turgor
