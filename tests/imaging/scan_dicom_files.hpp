// DICOM files written through GDCM, so that our reader is tested against another writer.
#pragma once

#include <fmt/format.h>
#include <gdcmImageChangeTransferSyntax.h>
#include <gdcmImageReader.h>
#include <gdcmImageWriter.h>
#include <gdcmJPEGLSCodec.h>
#include <gdcmSequenceOfItems.h>
#include <gdcmWriter.h>

#include <functional>

#include "imaging/scan_format_files.hpp"

namespace turgor::scan_test {

struct DicomSpec {
  int columns = 9, rows = 11;
  Vec3 position{}, row{1, 0, 0}, column{0, 1, 0};
  double column_spacing = 0.8, row_spacing = 1.1;  // between columns, between rows
  int allocated = 16, stored = 16;
  bool is_signed = true;
  std::string slope = "1", intercept = "0";
  std::string series = "1.2.3.4", description = "head", modality = "CT",
              image_type = "ORIGINAL\\PRIMARY\\AXIAL";
  std::string instance = "1.2.3.4.1";
  std::string pixels;  ///< as stored
  gdcm::TransferSyntax::TSType syntax = gdcm::TransferSyntax::ExplicitVRLittleEndian;
  std::function<void(gdcm::DataSet&)> edit = {};
};

inline void put(gdcm::DataSet& set, std::uint16_t group, std::uint16_t element, const char* vr,
                std::string value) {
  gdcm::DataElement e(gdcm::Tag(group, element));
  e.SetVR(gdcm::VR::GetVRTypeFromFile(vr));
  if (value.size() % 2 != 0) value += std::string(vr) == "UI" ? '\0' : ' ';
  e.SetByteValue(value.data(), gdcm::VL(static_cast<std::uint32_t>(value.size())));
  set.Replace(e);
}
inline void put_us(gdcm::DataSet& set, std::uint16_t group, std::uint16_t element, int value) {
  const auto v = static_cast<std::uint16_t>(value);
  put(set, group, element, "US", std::string(reinterpret_cast<const char*>(&v), 2));
}
inline std::string ds(const Vec3& v) {
  return fmt::format("{:.9g}\\{:.9g}\\{:.9g}", v.x, v.y, v.z);
}

inline void put_sequence(gdcm::DataSet& set, std::uint16_t group, std::uint16_t element,
                         const std::vector<gdcm::DataSet>& items) {
  gdcm::SmartPointer<gdcm::SequenceOfItems> sequence = new gdcm::SequenceOfItems;
  sequence->SetLengthToUndefined();
  for (const gdcm::DataSet& nested : items) {
    gdcm::Item item;
    item.SetVLToUndefined();
    item.SetNestedDataSet(nested);
    sequence->AddItem(item);
  }
  gdcm::DataElement e(gdcm::Tag(group, element));
  e.SetVR(gdcm::VR::SQ);
  e.SetValue(*sequence);
  e.SetVLToUndefined();
  set.Replace(e);
}

inline void fill(gdcm::DataSet& set, const DicomSpec& spec) {
  put(set, 0x0008, 0x0008, "CS", spec.image_type);
  put(set, 0x0008, 0x0016, "UI", "1.2.840.10008.5.1.4.1.1.2");
  put(set, 0x0008, 0x0018, "UI", spec.instance);
  put(set, 0x0008, 0x0060, "CS", spec.modality);
  put(set, 0x0008, 0x103E, "LO", spec.description);
  put(set, 0x0010, 0x0010, "PN", "Test^Patient");
  put(set, 0x0010, 0x0020, "LO", "1");
  put(set, 0x0020, 0x000D, "UI", "1.2.3");
  put(set, 0x0020, 0x000E, "UI", spec.series);
  put(set, 0x0020, 0x0032, "DS", ds(spec.position));
  put(set, 0x0020, 0x0037, "DS", ds(spec.row) + "\\" + ds(spec.column));
  put_us(set, 0x0028, 0x0002, 1);
  put(set, 0x0028, 0x0004, "CS", "MONOCHROME2");
  put_us(set, 0x0028, 0x0010, spec.rows);
  put_us(set, 0x0028, 0x0011, spec.columns);
  put(set, 0x0028, 0x0030, "DS", fmt::format("{:.9g}\\{:.9g}", spec.row_spacing, spec.column_spacing));
  put_us(set, 0x0028, 0x0100, spec.allocated);
  put_us(set, 0x0028, 0x0101, spec.stored);
  put_us(set, 0x0028, 0x0102, spec.stored - 1);
  put_us(set, 0x0028, 0x0103, spec.is_signed ? 1 : 0);
  put(set, 0x0028, 0x1052, "DS", spec.intercept);
  put(set, 0x0028, 0x1053, "DS", spec.slope);
  put(set, 0x7FE0, 0x0010, "OW", spec.pixels);
}

/// Rewrites a file's pixels in a compressed transfer syntax.
inline void recode(const std::filesystem::path& path, gdcm::TransferSyntax::TSType syntax) {
  gdcm::ImageReader reader;
  reader.SetFileName(path.c_str());
  ASSERT_TRUE(reader.Read());
  gdcm::ImageChangeTransferSyntax change;
  change.SetTransferSyntax(syntax);
  change.SetInput(reader.GetImage());
  ASSERT_TRUE(change.Change());
  gdcm::ImageWriter writer;
  writer.SetFile(reader.GetFile());
  writer.SetImage(change.GetOutput());
  writer.SetFileName(path.c_str());
  ASSERT_TRUE(writer.Write());
}

/// The same to JPEG-LS, with errors of at most `loss` in each pixel.
inline void recode_jpeg_ls(const std::filesystem::path& path, int loss) {
  gdcm::ImageReader reader;
  reader.SetFileName(path.c_str());
  ASSERT_TRUE(reader.Read());
  gdcm::JPEGLSCodec codec;
  codec.SetLossless(loss == 0);
  codec.SetLossyError(loss);
  gdcm::ImageChangeTransferSyntax change;
  change.SetTransferSyntax(loss == 0 ? gdcm::TransferSyntax::JPEGLSLossless
                                     : gdcm::TransferSyntax::JPEGLSNearLossless);
  change.SetUserCodec(&codec);
  change.SetInput(reader.GetImage());
  ASSERT_TRUE(change.Change());
  gdcm::ImageWriter writer;
  writer.SetFile(reader.GetFile());
  writer.SetImage(change.GetOutput());
  writer.SetFileName(path.c_str());
  ASSERT_TRUE(writer.Write());
}

inline void write_dicom(const std::filesystem::path& path, const DicomSpec& spec) {
  const gdcm::TransferSyntax wanted(spec.syntax);
  gdcm::Writer writer;
  writer.SetFileName(path.c_str());
  fill(writer.GetFile().GetDataSet(), spec);
  if (spec.edit) spec.edit(writer.GetFile().GetDataSet());
  gdcm::FileMetaInformation& meta = writer.GetFile().GetHeader();
  meta.SetDataSetTransferSyntax(wanted.IsEncapsulated() ? gdcm::TransferSyntax::ExplicitVRLittleEndian
                                                        : spec.syntax);
  ASSERT_TRUE(writer.Write());
  if (wanted.IsEncapsulated()) recode(path, spec.syntax);
}

/// A series of slices (0.dcm, 1.dcm …) that samples the marked volume on `lattice`. `edit` may change any
/// slice.
inline void write_series(const std::filesystem::path& folder, const Lattice& lattice,
                         const std::function<void(int, DicomSpec&)>& edit = {}) {
  const auto voxels = marked_voxels(lattice.size, lattice.mark);
  const std::size_t plane = static_cast<std::size_t>(lattice.size[0] * lattice.size[1]);
  for (int k = 0; k < lattice.size[2]; ++k) {
    DicomSpec spec;
    spec.columns = lattice.size[0], spec.rows = lattice.size[1];
    spec.position = lattice.origin + lattice.axes[2] * k;
    spec.row = normalized(lattice.axes[0]), spec.column = normalized(lattice.axes[1]);
    spec.column_spacing = length(lattice.axes[0]), spec.row_spacing = length(lattice.axes[1]);
    spec.instance = fmt::format("1.2.3.4.{}", k + 1);
    const auto* first = voxels.data() + static_cast<std::size_t>(k) * plane;
    spec.pixels = bytes_of({first, first + plane});
    if (edit) edit(k, spec);
    write_dicom(folder / fmt::format("{}.dcm", k), spec);
  }
}

}  // namespace turgor::scan_test
