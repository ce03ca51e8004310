// Seeded random streams: the value at (seed, stream, index) is a pure function, so loops may run in any
// order.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace turgor {

class RandomStream {
 public:
  explicit constexpr RandomStream(std::uint64_t seed, std::uint64_t stream = 0)
      : key_(mix(seed + 0x9E3779B97F4A7C15ULL * (stream + 1))) {}

  /// 64 random bits of the given index (SplitMix64 of Steele, Lea and Flood 2014, used as a counter).
  [[nodiscard]] constexpr std::uint64_t bits(std::uint64_t index) const {
    return mix(key_ + 0x9E3779B97F4A7C15ULL * (index + 1));
  }
  /// Uniform in [0, 1).
  [[nodiscard]] constexpr double uniform(std::uint64_t index) const {
    return static_cast<double>(bits(index) >> 11) * 0x1.0p-53;
  }
  /// Standard normal (Box and Muller).
  [[nodiscard]] double normal(std::uint64_t index) const {
    const double u = 1.0 - uniform(2 * index), v = uniform(2 * index + 1);
    return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v);
  }

 private:
  static constexpr std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
  }
  std::uint64_t key_;
};

}  // namespace turgor
