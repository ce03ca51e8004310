// What benchmarks are held against: the machine's copy bandwidth, and the number of threads.
#pragma once

#include <benchmark/benchmark.h>

#include <cstdint>
#include <cstring>
#include <vector>

#include "turgor/core/parallel.hpp"

namespace turgor::bench {

/// As many threads for as long as it lives.
class Threads {
 public:
  explicit Threads(std::int64_t count) { set_thread_count(static_cast<int>(count)); }
  ~Threads() { set_thread_count(0); }
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;
};

/// Reads and writes of 64 MiB by as many threads as the argument says.
inline void copy(benchmark::State& state) {
  const Threads threads(state.range(0));
  const std::size_t n = std::size_t{64} << 20;
  std::vector<char> from(n, 1), to(n, 0);
  for (auto _ : state) {
    parallel_for(n, n / 8, [&](std::size_t begin, std::size_t end) {
      std::memcpy(to.data() + begin, from.data() + begin, end - begin);
    });
    benchmark::ClobberMemory();
  }
  state.SetBytesProcessed(static_cast<std::int64_t>(2 * n) * state.iterations());
}

}  // namespace turgor::bench
