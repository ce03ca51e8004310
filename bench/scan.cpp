// How long scans take to come in and go out.
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "turgor/imaging/scan.hpp"

namespace {
using namespace turgor;
namespace fs = std::filesystem;

/// A ball of soft tissue with some texture, so that compression has work.
CtVolume ball(int columns, int slices) {
  Grid grid;
  grid.size = {columns, columns, slices};
  grid.spacing = {0.5, 0.5, 0.75};
  CtVolume volume(grid, -1000);
  for (int k = 0; k < slices; ++k) {
    for (int j = 0; j < columns; ++j) {
      for (int i = 0; i < columns; ++i) {
        const double x = i - columns / 2, y = j - columns / 2;
        const int texture = (i * 7 + j * 13 + k * 29) % 31;
        if (std::hypot(x, y) < columns * 0.4) volume.at(i, j, k) = static_cast<std::int16_t>(40 + texture);
      }
    }
  }
  return volume;
}

void ReadRealScan(benchmark::State& state) {
  const fs::path path = "/usr/share/doc/invesalius-examples/examples/Cranium.inv3";
  if (!fs::exists(path)) state.SkipWithError("the Debian package invesalius-examples is not installed");
  for (auto _ : state) {
    Context context;
    auto scan = read_scan(path, {}, context);
    if (!scan) state.SkipWithError(scan.error().message().c_str());
    benchmark::DoNotOptimize(scan);
  }
}
BENCHMARK(ReadRealScan)->Unit(benchmark::kMillisecond)->UseRealTime();

class Files : public benchmark::Fixture {
 public:
  void SetUp(const benchmark::State&) override {
    folder_ = fs::temp_directory_path() / ("turgor_bench_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    volume_ = ball(512, 300);
  }
  void TearDown(const benchmark::State&) override {
    fs::remove_all(folder_);
    volume_ = {};
  }

 protected:
  fs::path folder_;
  CtVolume volume_;
};

BENCHMARK_DEFINE_F(Files, WriteDicom300Slices)(benchmark::State& state) {
  for (auto _ : state) {
    Context context;
    if (!write_dicom_series(folder_, volume_, {}, context)) state.SkipWithError("cannot be written");
  }
}
BENCHMARK_DEFINE_F(Files, ReadDicom300Slices)(benchmark::State& state) {
  Context context;
  if (!write_dicom_series(folder_, volume_, {}, context)) state.SkipWithError("cannot be written");
  for (auto _ : state) {
    auto scan = read_scan(folder_, {}, context);
    if (!scan) state.SkipWithError(scan.error().message().c_str());
    benchmark::DoNotOptimize(scan);
  }
}
BENCHMARK_DEFINE_F(Files, WriteNrrd300Slices)(benchmark::State& state) {
  for (auto _ : state) {
    if (!write_nrrd(folder_ / "a.nrrd", volume_)) state.SkipWithError("cannot be written");
  }
}
BENCHMARK_DEFINE_F(Files, ReadNrrd300Slices)(benchmark::State& state) {
  if (!write_nrrd(folder_ / "a.nrrd", volume_)) state.SkipWithError("cannot be written");
  for (auto _ : state) {
    Context context;
    auto scan = read_scan(folder_ / "a.nrrd", {}, context);
    if (!scan) state.SkipWithError(scan.error().message().c_str());
    benchmark::DoNotOptimize(scan);
  }
}

BENCHMARK_REGISTER_F(Files, WriteDicom300Slices)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_REGISTER_F(Files, ReadDicom300Slices)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_REGISTER_F(Files, WriteNrrd300Slices)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_REGISTER_F(Files, ReadNrrd300Slices)->Unit(benchmark::kMillisecond)->UseRealTime();
}  // namespace
