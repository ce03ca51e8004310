// What benchmarks of real surfaces read, and what they measure of themselves.
#pragma once

#include <sys/resource.h>

#include <chrono>
#include <filesystem>
#include <optional>

#include "turgor/geometry/mesh_file.hpp"
#include "turgor/geometry/voxel_solid.hpp"

namespace turgor::bench {

/// Of bunny, gear, happy and dragon, from where benchmarks are run or where the sources lie; empty where
/// there is none.
inline std::filesystem::path mesh_folder() {
  for (const char* const folder : {"../shared/data/meshes", "../../shared/data/meshes"}) {
    if (std::filesystem::exists(std::filesystem::path(folder) / "bunny.ply")) return folder;
  }
  return {};
}

/// As the file has it, in metres and upright along y.
inline std::optional<TriMesh> bunny_surface() {
  const std::filesystem::path folder = mesh_folder();
  if (folder.empty()) return std::nullopt;
  auto surface = read_mesh(folder / "bunny.ply");
  return surface ? std::optional(*std::move(surface)) : std::nullopt;
}

inline std::optional<SolidMesh> solid_in(const TriMesh& surface, const VoxelOptions& options) {
  const auto voxels = voxelise(surface, options);
  if (!voxels) return std::nullopt;
  auto solid = solid_of(*voxels);
  return solid ? std::optional(*std::move(solid)) : std::nullopt;
}

inline double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Of this process so far.
inline double peak_mb() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

}  // namespace turgor::bench
