// What mpi_farm_test starts, alone and by mpirun: prints the bits of fits, or how one fails.
#include <chrono>
#include <cstdio>
#include <cstring>
#include <string>
#include <thread>

#include "calibration/analytic_models.hpp"
#include "mpi_farm.hpp"

namespace turgor {
namespace {

using namespace testing_models;

// The valley of the tests of calibration; slow enough for every process to get its share.
struct Valley {
  FormulaModel model{2, 1, [](std::span<const double> p, std::size_t) {
                       std::this_thread::sleep_for(std::chrono::microseconds(300));
                       return rosenbrock(p);
                     }};
  CalibrationProblem problem{
      &model, {linear(-2, 2, -0.2), linear(-1, 3, -0.2)}, {{"", {{{0, 0, 0}}, {}}, {}}}};
};

SampleError sample_error_of(const Valley& valley, const std::string& mode, int rank) {
  SampleError plain = make_sample_error(valley.problem, ErrorMeasure::distance);
  if (mode != "fault" || rank != 1) return plain;
  return [plain, calls = std::make_shared<std::atomic<int>>(0)](std::span<const double> parameters,
                                                                Context& context) -> Result<double> {
    if (++*calls == 7) return Error{ErrorKind::system, "the disk is full"};
    return plain(parameters, context);
  };
}

void print_fit(const Valley& valley, FitMethod method, SampleFarm& farm, Context& context) {
  FitOptions options;
  options.method = method;
  options.coarse_samples = 40;
  options.budget = 160;
  const auto fit = calibrate(valley.problem, options, context, &farm);
  if (!fit) {
    std::printf("%s\n", fit.error().message().c_str());
    return;
  }
  std::printf("%s %zu samples, %d failed%s", std::string(name_of(method)).c_str(), fit->samples.size(),
              fit->failed, fit->stopped ? ", stopped" : "");
  for (const double p : fit->parameters) std::printf(" %a", p);
  for (const FitSample& sample : fit->samples) std::printf(" %a", sample.error);
  std::printf("\n");
}

int run(const std::string& mode) {
  const auto processes = MpiProcesses::join();
  if (!processes) return std::printf("%s\n", processes.error().message().c_str()), 2;
  const int rank = (*processes)->rank();
  if (mode == "early" && rank == 1) return 0;
  const Valley valley;
  const SampleError sample_error = sample_error_of(valley, mode, rank);
  if (mode == "unused" && rank == 0) return 0;
  for (const auto method : {FitMethod::gauss_newton, FitMethod::cma_es, FitMethod::annealing}) {
    if (rank > 0) {
      if (!(*processes)->work(sample_error)) return mode == "unused" ? 0 : 1;
      continue;
    }
    const auto farm = (*processes)->make_farm(sample_error);
    // Stopped in the middle of the coarse samples, by what process 0 has done of them.
    valley.model.runs = 0;
    Context context({}, {}, [&] { return mode == "stop" && valley.model.runs > 10; });
    print_fit(valley, method, *farm, context);
  }
  return 0;
}

}  // namespace
}  // namespace turgor

int main(int argc, char** argv) {
  return turgor::run(argc > 1 ? argv[1] : "");
}
