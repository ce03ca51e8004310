// Small files of every format but DICOM, written byte by byte here so that readers are not tested against
// their twins.
#pragma once

#include <fmt/format.h>

#include <cstring>

#include "imaging/scan/inflate.hpp"
#include "imaging/scan_support.hpp"

namespace turgor::scan_test {

inline std::string bytes_of(const std::vector<std::int16_t>& values, bool big_endian = false) {
  std::string out;
  for (const std::int16_t v : values) {
    const auto u = static_cast<std::uint16_t>(v);
    const char low = static_cast<char>(u & 0xFF), high = static_cast<char>(u >> 8);
    out += big_endian ? std::string{high, low} : std::string{low, high};
  }
  return out;
}

inline std::string gzip(const std::string& text) {
  const auto packed = scan_io::gzip_bytes(std::as_bytes(std::span(text.data(), text.size())), 6);
  return {reinterpret_cast<const char*>(packed.data()), packed.size()};
}

inline std::string vector_text(const Vec3& v) {
  return fmt::format("({:.17g},{:.17g},{:.17g})", v.x, v.y, v.z);
}

/// Attached NRRD header; `signs` turns LPS numbers into those of `space`.
inline std::string nrrd_header(const Lattice& l, const std::string& space = "left-posterior-superior",
                               const Vec3& signs = {1, 1, 1}, const std::string& type = "int16",
                               const std::string& rest = "endian: little\nencoding: raw\n") {
  const auto in_space = [&](const Vec3& v) {
    return vector_text({v.x * signs.x, v.y * signs.y, v.z * signs.z});
  };
  return fmt::format(
      "NRRD0004\n# made for a test\ntype: {}\ndimension: 3\nspace: {}\nsizes: {} {} {}\n"
      "space directions: {} {} {}\nkinds: domain domain domain\nspace origin: {}\n{}",
      type, space, l.size[0], l.size[1], l.size[2], in_space(l.axes[0]), in_space(l.axes[1]),
      in_space(l.axes[2]), in_space(l.origin), rest);
}

inline std::string meta_header(const Lattice& l, const std::string& rest = "CompressedData = False\n",
                               const std::string& data_file = "LOCAL") {
  std::string matrix, spacing;
  for (const Vec3& axis : l.axes) {
    const Vec3 unit = normalized(axis);
    matrix += fmt::format(" {:.17g} {:.17g} {:.17g}", unit.x, unit.y, unit.z);
    spacing += fmt::format(" {:.17g}", length(axis));
  }
  return fmt::format(
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
      "TransformMatrix ={}\nOffset = {:.17g} {:.17g} {:.17g}\nCenterOfRotation = 0 0 0\nElementSpacing ={}\n"
      "DimSize = {} {} {}\n{}ElementType = MET_SHORT\nElementDataFile = {}\n",
      matrix, l.origin.x, l.origin.y, l.origin.z, spacing, l.size[0], l.size[1], l.size[2], rest, data_file);
}

/// Numbers at fixed places of a binary header, in either byte order.
class BinaryHeader {
 public:
  BinaryHeader(std::size_t size, bool big_endian) : bytes_(size, '\0'), big_(big_endian) {}
  template <class T>
  void put(std::size_t at, T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    if (big_) std::reverse(raw, raw + sizeof(T));
    bytes_.replace(at, sizeof(T), raw, sizeof(T));
  }
  void put_text(std::size_t at, const std::string& text) { bytes_.replace(at, text.size(), text); }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  bool big_;
};

struct NiftiSpec {
  bool big_endian = false;
  bool use_qform = false;
  std::int16_t datatype = 4;
  float slope = 0, intercept = 0;
  std::string magic = "n+1";
};

/// Unit quaternion (b, c, d; a ≥ 0) of a rotation, by its axis and angle.
inline Vec3 quaternion_of(const Mat3& r) {
  const double a = 0.5 * std::sqrt(std::max(0.0, 1 + r.c[0].x + r.c[1].y + r.c[2].z));
  if (a > 1e-3) return Vec3{r.c[1].z - r.c[2].y, r.c[2].x - r.c[0].z, r.c[0].y - r.c[1].x} / (4 * a);
  // A half turn: the columns of R + 1 are multiples of the axis.
  Vec3 best{};
  for (int n = 0; n < 3; ++n) {
    Vec3 column = r.c[static_cast<std::size_t>(n)];
    column[n] += 1;
    if (length(column) > length(best)) best = column;
  }
  return normalized(best);
}

/// NIfTI-1 header (352 bytes with the extension flag) of a lattice given in LPS; the file's space is RAS.
inline std::string nifti_header(const Lattice& l, const NiftiSpec& spec = {}) {
  BinaryHeader h(352, spec.big_endian);
  const auto ras = [](const Vec3& v) { return Vec3{-v.x, -v.y, v.z}; };
  std::array<Vec3, 3> axes{ras(l.axes[0]), ras(l.axes[1]), ras(l.axes[2])};
  const Vec3 origin = ras(l.origin);
  h.put<std::int32_t>(0, 348);
  h.put<std::int16_t>(40, 3);
  for (std::size_t n = 0; n < 3; ++n) {
    h.put<std::int16_t>(42 + 2 * n, static_cast<std::int16_t>(l.size[n]));
    h.put<float>(80 + 4 * n, static_cast<float>(length(axes[n])));
  }
  h.put<std::int16_t>(70, spec.datatype);
  h.put<float>(108, spec.magic == "n+1" ? 352.0F : 0.0F);
  h.put<float>(112, spec.slope);
  h.put<float>(116, spec.intercept);
  h.put<std::uint8_t>(123, 2);
  if (spec.use_qform) {
    Mat3 turn{{normalized(axes[0]), normalized(axes[1]), normalized(axes[2])}};
    const bool left = turn.determinant() < 0;
    if (left) turn.c[2] = -turn.c[2];
    const Vec3 q = quaternion_of(turn);
    h.put<float>(76, left ? -1.0F : 1.0F);
    h.put<std::int16_t>(252, 1);
    for (int n = 0; n < 3; ++n) h.put<float>(256 + 4 * static_cast<std::size_t>(n), static_cast<float>(q[n]));
    for (int n = 0; n < 3; ++n)
      h.put<float>(268 + 4 * static_cast<std::size_t>(n), static_cast<float>(origin[n]));
  } else {
    h.put<std::int16_t>(254, 1);
    for (int n = 0; n < 3; ++n) {
      const std::size_t row = 280 + 16 * static_cast<std::size_t>(n);
      for (std::size_t a = 0; a < 3; ++a) h.put<float>(row + 4 * a, static_cast<float>(axes[a][n]));
      h.put<float>(row + 12, static_cast<float>(origin[n]));
    }
  }
  h.put_text(344, spec.magic);
  return h.bytes();
}

/// One member of a tar archive (POSIX ustar).
inline std::string tar_member(const std::string& name, const std::string& data) {
  std::string head(512, '\0');
  head.replace(0, name.size(), name);
  head.replace(100, 7, "0000644");
  head.replace(124, 11, fmt::format("{:011o}", data.size()));
  head.replace(136, 11, "00000000000");
  head.replace(148, 8, "        ");
  head[156] = '0';
  head.replace(257, 5, "ustar");
  head.replace(263, 2, "00");
  unsigned sum = 0;
  for (const char c : head) sum += static_cast<unsigned char>(c);
  head.replace(148, 7, fmt::format("{:06o}", sum) + std::string(1, '\0'));
  std::string padded = data;
  padded.resize((data.size() + 511) / 512 * 512, '\0');
  return head + padded;
}

inline std::string inv3_plist(const Index3& size, const Vec3& spacing) {
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<plist version=\"1.0\">\n<dict>\n<key>matrix</key><dict>"
      "<key>dtype</key><string>int16</string><key>filename</key><string>matrix.dat</string><key>shape</key>"
      "<array><integer>{}</integer><integer>{}</integer><integer>{}</integer></array></dict>"
      "<key>modality</key><string>CT</string><key>name</key><string>TEST 1</string>"
      "<key>spacing</key><array><real>{}</real><real>{}</real><real>{}</real></array></dict></plist>\n",
      size[2], size[1], size[0], spacing.x, spacing.y, spacing.z);
}

inline std::string inv3_file(const std::string& plist, const std::string& matrix, bool plist_first = true) {
  const std::string head = tar_member("tmpabc/main.plist", plist),
                    body = tar_member("tmpabc/matrix.dat", matrix);
  return gzip((plist_first ? head + body : body + head) + std::string(1024, '\0'));
}

}  // namespace turgor::scan_test
