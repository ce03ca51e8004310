// Simulated annealing with adaptive neighbourhoods (Corana, Marchesi, Martini and Ridella 1987) by pagmo, in
// several chains. Each chain asks for one sample at a time; the samples that all chains ask for are evaluated
// together, so that threads and processes share them and the order does not depend on the clock.
#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <pagmo/algorithms/simulated_annealing.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>
#include <string>
#include <thread>

#include "calibration/search.hpp"
#include "turgor/core/random.hpp"

namespace turgor {
namespace {

constexpr std::uint64_t seed_stream = 4;

// Thrown through pagmo to end a chain, caught below.
struct ChainEnd {};

// Where chains meet the one thread that evaluates.
class Meeting {
 public:
  explicit Meeting(std::size_t chains) : asked_(chains), answered_(chains), over_(chains, false) {}

  // By a chain: waits for the error of its sample; nothing when the search ends.
  std::optional<double> ask(std::size_t chain, const std::vector<double>& unit) {
    std::unique_lock lock(mutex_);
    if (ended_) return std::nullopt;
    asked_[chain] = Eigen::VectorXd::Map(unit.data(), static_cast<Eigen::Index>(unit.size()));
    changed_.notify_all();
    changed_.wait(lock, [&] { return ended_ || answered_[chain]; });
    if (ended_) return std::nullopt;
    const auto error = answered_[chain];
    answered_[chain].reset();
    return error;
  }
  // By a chain that has ended, with what pagmo says where that is not our doing.
  void leave(std::size_t chain, const std::string& fault) {
    const std::lock_guard lock(mutex_);
    over_[chain] = true;
    if (!fault.empty()) fault_ = fault;
    changed_.notify_all();
  }

  // By the evaluating thread: the chains that wait, once all that are not over do; none: all are over.
  std::vector<std::size_t> wait_for_all() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] {
      for (std::size_t c = 0; c < over_.size(); ++c) {
        if (!over_[c] && !asked_[c]) return false;
      }
      return true;
    });
    std::vector<std::size_t> waiting;
    for (std::size_t c = 0; c < over_.size(); ++c) {
      if (!over_[c]) waiting.push_back(c);
    }
    return waiting;
  }
  [[nodiscard]] Eigen::VectorXd take(std::size_t chain) {
    const std::lock_guard lock(mutex_);
    Eigen::VectorXd unit = *std::move(asked_[chain]);
    asked_[chain].reset();
    return unit;
  }
  void answer(const std::vector<std::size_t>& chains, const std::vector<double>& errors) {
    const std::lock_guard lock(mutex_);
    for (std::size_t k = 0; k < chains.size(); ++k) answered_[chains[k]] = errors[k];
    changed_.notify_all();
  }
  [[nodiscard]] Result<void> check() {
    const std::lock_guard lock(mutex_);
    if (!fault_.empty()) return Error{ErrorKind::internal, "annealing failed: " + fault_};
    return {};
  }
  void end() {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::optional<Eigen::VectorXd>> asked_;
  std::vector<std::optional<double>> answered_;
  std::vector<bool> over_;
  bool ended_ = false;
  std::string fault_;
};

// Lets the chains go, whatever ends the search.
struct MeetingEnd {
  Meeting& meeting;
  ~MeetingEnd() { meeting.end(); }
};

// pagmo's view of a chain.
struct ChainProblem {
  Meeting* meeting = nullptr;
  std::size_t chain = 0;
  std::size_t size = 1;
  std::shared_ptr<int> left = std::make_shared<int>(0);

  [[nodiscard]] std::vector<double> fitness(const std::vector<double>& unit) const {
    if (--*left < 0) throw ChainEnd{};
    const auto error = meeting->ask(chain, unit);
    if (!error) throw ChainEnd{};
    return {*error};
  }
  [[nodiscard]] std::pair<std::vector<double>, std::vector<double>> get_bounds() const {
    return {std::vector<double>(size, 0.0), std::vector<double>(size, 1.0)};
  }
  template <class Archive>
  void serialize(Archive& /*archive*/, unsigned /*version*/) {}
};

struct ChainStart {
  Eigen::VectorXd unit;
  double error = 0;
  int budget = 0;
  std::uint64_t seed = 0;
};

// Temperatures from a tenth of the error at the start to a ten thousandth. Samples are cycles over all
// parameters; of these, as many go into one adaption of the neighbourhoods as there are adaptions at one
// temperature, and no more than ten.
pagmo::simulated_annealing schedule(const ChainStart& start) {
  const double cycles = std::max(1.0, std::ceil(start.budget / static_cast<double>(start.unit.size())));
  const auto bin = static_cast<unsigned>(std::clamp(std::floor(std::cbrt(cycles)), 1.0, 10.0));
  const auto temperatures = static_cast<unsigned>(std::ceil(cycles / (bin * bin)));
  const double first = std::max(0.1 * start.error, 1e-300);
  return pagmo::simulated_annealing(first, 1e-3 * first, temperatures, bin, bin, 0.5,
                                    static_cast<unsigned>(start.seed));
}

void run_chain(Meeting& meeting, std::size_t chain, const ChainStart& start) {
  std::string fault;
  try {
    const std::vector<double> unit(start.unit.begin(), start.unit.end());
    const pagmo::problem problem(
        ChainProblem{&meeting, chain, unit.size(), std::make_shared<int>(start.budget)});
    pagmo::population population(problem, 0, static_cast<unsigned>(start.seed >> 32));
    population.push_back(unit, {start.error});
    (void)schedule(start).evolve(population);
  } catch (const ChainEnd&) {
    // Its budget is spent, or the search is over; every sample is recorded already.
  } catch (const std::exception& error) {
    fault = error.what();
  }
  meeting.leave(chain, fault);
}

Result<void> serve_chains(Search& search, Meeting& meeting) {
  for (;;) {
    const std::vector<std::size_t> waiting = meeting.wait_for_all();
    if (waiting.empty()) return meeting.check();
    std::vector<Eigen::VectorXd> units;
    units.reserve(waiting.size());
    for (const std::size_t chain : waiting) units.push_back(meeting.take(chain));
    TURGOR_TRY(const std::vector<double> errors, search.evaluate(FitSample::Stage::search, units));
    meeting.answer(waiting, errors);
  }
}

}  // namespace

Result<void> search_by_annealing(Search& search) {
  const auto chains = static_cast<std::size_t>(std::min(search.options().chains, search.left()));
  const auto starts = search.starts();
  const RandomStream random(search.options().seed, seed_stream);
  Meeting meeting(chains);
  std::vector<std::jthread> threads;  // join when they go
  const MeetingEnd end{meeting};
  threads.reserve(chains);
  for (std::size_t c = 0; c < chains; ++c) {
    const auto& [error, unit] = starts[c % starts.size()];
    const int share = search.left() / static_cast<int>(chains) +
                      (static_cast<int>(c) < search.left() % static_cast<int>(chains) ? 1 : 0);
    threads.emplace_back(run_chain, std::ref(meeting), c, ChainStart{unit, error, share, random.bits(c)});
  }
  return serve_chains(search, meeting);
}

}  // namespace turgor
