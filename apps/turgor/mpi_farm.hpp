// Samples of a calibration shared among the processes that mpirun or Slurm have started together.
#pragma once

#include <memory>
#include <vector>

#include "turgor/calibration/calibrate.hpp"

namespace turgor {

/// The processes of this run, for as long as it lives: one a program, made before any farm. MPI begins only
/// where a launcher has started several; alone, and in a program built without MPI, there is process 0 of 1.
/// All members are for the thread that made it.
///
///     TURGOR_TRY(const auto processes, MpiProcesses::join());
///     ... every process reads the same problem ...
///     if (processes->rank() > 0) return processes->work(make_sample_error(problem, measure));
///     const auto farm = processes->make_farm(make_sample_error(problem, measure));
///     auto fit = calibrate(problem, options, context, farm.get());
///
/// Several calibrations one after another: a farm at process 0, and a call of work() at the others, for each.
/// Where process 0 ends, of whatever cause, the others are let go; one that has ended when a farm needs it is
/// an error at process 0.
class MpiProcesses {
 public:
  /// Errors: several processes, but built without MPI; MPI does not start.
  static Result<std::unique_ptr<MpiProcesses>> join();
  ~MpiProcesses();
  MpiProcesses(const MpiProcesses&) = delete;
  MpiProcesses& operator=(const MpiProcesses&) = delete;

  [[nodiscard]] int rank() const { return rank_; }
  [[nodiscard]] int count() const { return static_cast<int>(ended_.size()); }

  /// Of process 0: hands samples out, as many at once as a process has threads, to whoever is idle, and works
  /// itself. Errors are in the order of the samples, the same bits for any number of processes. Waits for the
  /// others to come to work. One at a time; must not outlive this.
  std::unique_ptr<SampleFarm> make_farm(SampleError sample_error);
  /// Of the others: does what the farm of process 0 asks for until that is gone. A stop is process 0's to
  /// decide. Errors: process 0 has ended, of kind cancelled: it has said why.
  Result<void> work(SampleError sample_error);

 private:
  MpiProcesses() = default;
  int rank_ = 0;
  std::vector<bool> ended_{false};         // of each process, as process 0 knows
  [[maybe_unused]] bool over_ = false;     // process 0 has ended
  [[maybe_unused]] bool started_ = false;  // MPI has
};

}  // namespace turgor
