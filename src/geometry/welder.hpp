// Points that are equal get one number. Internal to the module.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <unordered_map>

#include "turgor/geometry/tri_mesh.hpp"

namespace turgor::detail {

/// Numbers points so that equal ones share a number, and adds new ones to the mesh.
class Welder {
 public:
  explicit Welder(TriMesh& mesh) : mesh_(mesh) {}
  int number(const Vec3& p) {
    // Adding zero makes -0 and 0 the same.
    const Key key{std::bit_cast<std::uint64_t>(p.x + 0.0), std::bit_cast<std::uint64_t>(p.y + 0.0),
                  std::bit_cast<std::uint64_t>(p.z + 0.0)};
    const auto [entry, is_new] = numbers_.try_emplace(key, static_cast<int>(mesh_.points.size()));
    if (is_new) mesh_.points.push_back(p);
    return entry->second;
  }

 private:
  using Key = std::array<std::uint64_t, 3>;
  struct Hash {
    std::size_t operator()(const Key& k) const {
      std::uint64_t h = 0;
      for (const std::uint64_t word : k) h = (h ^ word) * 0x9E3779B97F4A7C15ULL, h ^= h >> 29;
      return static_cast<std::size_t>(h);
    }
  };
  TriMesh& mesh_;
  std::unordered_map<Key, int, Hash> numbers_;
};

}  // namespace turgor::detail
