// The plain binary file of a solid: see solid_file.hpp.
#include <algorithm>
#include <cstring>

#include "geometry/bytes.hpp"
#include "geometry/solid_write.hpp"
#include "turgor/core/file.hpp"

namespace turgor {
namespace {

constexpr std::string_view kMagic = "TURGSOL1";

/// Takes arrays off the front of a file whose length has been checked.
class ArrayReader {
 public:
  explicit ArrayReader(std::span<const std::byte> bytes) : left_(bytes) {}
  template <class T>
  void take(T* to, std::size_t count) {
    if (count == 0) return;
    std::memcpy(to, left_.data(), count * sizeof(T));
    left_ = left_.subspan(count * sizeof(T));
  }
  template <class T>
  void take(std::vector<T>& to, std::size_t count) {
    to.resize(count);
    take(to.data(), count);
  }

 private:
  std::span<const std::byte> left_;
};

struct Header {
  std::uint64_t points, cells, corners, triangles;
  double spacing;
};

/// The length of a file with this header, or 0 where its counts cannot be.
std::uint64_t length_of(const Header& h) {
  constexpr std::uint64_t most = std::uint64_t{1} << 31;
  if (h.points > most || h.cells > most || h.triangles > most || (h.corners != 4 && h.corners != 8)) return 0;
  return kMagic.size() + sizeof(Header) + 25 * h.points + 4 * h.cells * h.corners + 16 * h.triangles;
}

bool all_below(const int* values, std::size_t count, std::size_t limit) {
  return std::all_of(values, values + count,
                     [&](int v) { return v >= 0 && static_cast<std::size_t>(v) < limit; });
}

Result<void> check(const SolidFile& file, const std::filesystem::path& path) {
  const std::size_t points = file.points.size(),
                    cells = file.cells.size() / static_cast<std::size_t>(file.corners);
  const auto fail = [&](const char* what) {
    return Error{ErrorKind::bad_input, what, path.string(), "Write the solid again"};
  };
  if (!std::all_of(file.points.begin(), file.points.end(), is_finite<double>) || !std::isfinite(file.spacing))
    return fail("a coordinate of the solid is not finite");
  if (!all_below(file.cells.data(), file.cells.size(), points) ||
      !all_below(file.surface_cells.data(), file.surface_cells.size(), cells))
    return fail("a cell of the solid names what is not there");
  for (const Index3& t : file.surface_triangles) {
    if (!all_below(t.data(), 3, points))
      return fail("a triangle of the solid names a point that is not there");
  }
  return {};
}

}  // namespace

Result<SolidFile> read_solid(const std::filesystem::path& path) {
  TURGOR_TRY(const std::vector<std::byte> bytes, read_file(path));
  const auto fail = [&](const char* what) {
    return Error{ErrorKind::bad_input, what, path.string(), "Give a file that turgor mesh wrote"};
  };
  if (bytes.size() < kMagic.size() + sizeof(Header) ||
      std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) != 0)
    return fail("this is not a plain binary solid");
  ArrayReader in(std::span<const std::byte>(bytes).subspan(kMagic.size()));
  Header head{};
  in.take(&head, 1);
  if (length_of(head) != bytes.size()) return fail("the file is not as long as it says");
  SolidFile file;
  file.spacing = head.spacing, file.corners = static_cast<int>(head.corners);
  in.take(file.points, head.points);
  in.take(file.cells, head.cells * head.corners);
  in.take(file.surface_triangles, head.triangles);
  in.take(file.surface_cells, head.triangles);
  in.take(file.on_surface, head.points);
  TURGOR_CHECK(check(file, path));
  return file;
}

Result<void> detail::write_plain_solid(const std::filesystem::path& path, const SolidView& view) {
  const SolidMesh& solid = view.solid;
  const Header head{solid.points.size(), view.cell_count(), static_cast<std::uint64_t>(view.corners),
                    solid.surface_triangles.size(), solid.spacing};
  ByteWriter out(length_of(head));
  out.text(kMagic);
  for (const std::uint64_t n : {head.points, head.cells, head.corners, head.triangles}) out.put(n);
  out.put(head.spacing);
  for (const Vec3& p : solid.points) out.put(p.x), out.put(p.y), out.put(p.z);
  for (const int p : view.connectivity) out.put(p);
  for (const Index3& t : solid.surface_triangles)
    for (const int p : t) out.put(p);
  for (std::size_t t = 0; t < solid.surface_triangles.size(); ++t) out.put(view.behind(t));
  out.put_all(solid.on_surface);
  return write_file(path, out.bytes());
}

}  // namespace turgor
