// Any bytes as a surface file of every kind: an error or a sound mesh, never a crash.
#include <cstdint>
#include <cstdlib>
#include <span>

#include "turgor/geometry/mesh_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  for (const char* name :
       {"fuzz.ply", "fuzz.stl", "fuzz.obj", "fuzz.off", "fuzz.vtk", "fuzz.vtp", "fuzz.gltf"}) {
    const auto mesh = turgor::parse_mesh(bytes, name);
    if (mesh && (mesh->empty() || !turgor::validate(*mesh))) std::abort();
  }
  const auto cells = turgor::parse_vtu(bytes, "fuzz.vtu");
  if (cells && cells->mesh.offsets.size() != cells->mesh.types.size()) std::abort();
  return 0;
}
