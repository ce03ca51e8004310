// Whole runs, scan to report, by the program itself: wall time, processor time, peak memory, and where the
// time goes. Usage: bench_run [runs]
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/example_scan.hpp"

namespace {

struct Run {
  int status = 0;
  double wall_s = 0, processor_s = 0, peak_gb = 0;
};

double seconds(const timeval& t) {
  return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

Run run(const std::vector<std::string>& command) {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const auto start = std::chrono::steady_clock::now();
  const pid_t child = fork();
  if (child == 0) {
    const int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, 1);
    dup2(nowhere, 2);
    execv(arguments[0], arguments.data());
    _exit(127);
  }
  Run out;
  rusage usage{};
  wait4(child, &out.status, 0, &usage);
  out.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  out.processor_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  out.peak_gb = static_cast<double>(usage.ru_maxrss) / (1024.0 * 1024.0);
  return out;
}

void print_stages(const std::filesystem::path& result) {
  std::ifstream file(result);
  const auto json = nlohmann::ordered_json::parse(file, nullptr, false);
  if (json.is_discarded() || !json.contains("seconds")) return;
  for (const auto& [stage, time] : json["seconds"].items()) {
    std::printf("    %-24s %7.3f s\n", stage.c_str(), time.get<double>());
  }
}

// False where the program fails.
bool measure(const char* title, std::vector<std::string> command, int runs) {
  const auto folder = std::filesystem::temp_directory_path() / ("turgor_bench_" + std::to_string(::getpid()));
  command.insert(command.end(), {"-o", folder.string()});
  std::puts(title);
  for (int i = 0; i < runs; ++i) {
    const Run r = run(command);
    if (r.status != 0) {
      std::printf("turgor ended with status %d\n", r.status);
      return false;
    }
    std::printf("  run %d: %.2f s wall, %.2f s processor, peak %.2f GB\n", i + 1, r.wall_s, r.processor_s,
                r.peak_gb);
    if (i + 1 == runs) print_stages(folder / "result.json");
    std::filesystem::remove_all(folder);
  }
  return true;
}

// The phantom's jaw set back by 6 mm: the Mooney-Rivlin law on 95,000 cubes.
bool measure_setback(int runs) {
  const auto phantom =
      std::filesystem::temp_directory_path() / ("turgor_phantom_" + std::to_string(::getpid()));
  bool good = run({TURGOR_PROGRAM, "phantom", "-jaw_protrusion", "6", "-o", phantom.string()}).status == 0;
  good = good && measure("phantom to report (predict, setback of 6 mm, fem)",
                         {TURGOR_PROGRAM, "predict", (phantom / "dicom").string(), "-solver", "fem", "-plan",
                          TURGOR_SOURCE_DIR "/examples/setback.turgor"},
                         runs);
  std::filesystem::remove_all(phantom);
  return good;
}

}  // namespace

int main(int argc, char** argv) {
  const int runs = argc > 1 ? std::max(1, std::atoi(argv[1])) : 3;
  bool good = measure_setback(runs);
  const std::filesystem::path scan = turgor::test::example_scan();
  if (scan.empty() || !std::filesystem::exists(scan))
    std::puts("skipped: the example scan is not installed (Debian package invesalius-examples)");
  else
    good = measure("real scan to report (predict, Le Fort I, both solvers)",
                   {TURGOR_PROGRAM, "predict", scan.string(), "-plan",
                    TURGOR_SOURCE_DIR "/examples/le_fort_1.turgor"},
                   runs) &&
           good;
  return good ? 0 : 1;
}
