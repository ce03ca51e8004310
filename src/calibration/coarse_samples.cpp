// A stable start: samples over all the bounds before the search (Morris 2006, section 3.2).
#include <algorithm>
#include <cmath>
#include <numeric>

#include "calibration/search.hpp"
#include "turgor/core/random.hpp"

namespace turgor {
namespace {

// Streams of random numbers, apart from those of the methods.
enum : std::uint64_t { hypercube_stream = 1, random_stream = 2 };

// A Latin hypercube (McKay, Beckman and Conover 1979): of `count` equal parts of each parameter's range each
// has one sample, anywhere in it.
std::vector<Eigen::VectorXd> latin_hypercube(int count, Eigen::Index size, std::uint64_t seed) {
  const RandomStream random(seed, hypercube_stream);
  std::vector<Eigen::VectorXd> out(static_cast<std::size_t>(count), Eigen::VectorXd(size));
  std::vector<int> part(out.size());
  std::uint64_t next = 0;
  for (Eigen::Index axis = 0; axis < size; ++axis) {
    std::iota(part.begin(), part.end(), 0);
    for (std::size_t i = part.size(); i > 1; --i) {
      const auto other = static_cast<std::size_t>(random.uniform(next++) * static_cast<double>(i));
      std::swap(part[i - 1], part[other]);
    }
    for (std::size_t i = 0; i < out.size(); ++i) out[i][axis] = (part[i] + random.uniform(next++)) / count;
  }
  return out;
}

Result<void> sample_until_one_rests(Search& search) {
  const RandomStream random(search.options().seed, random_stream);
  std::uint64_t next = 0;
  while (!search.has_best() && search.left() > 0) {
    std::vector<Eigen::VectorXd> units(static_cast<std::size_t>(std::min(search.left(), search.farm_width())),
                                       Eigen::VectorXd(search.space().size()));
    for (Eigen::VectorXd& unit : units) {
      for (double& place : unit) place = random.uniform(next++);
    }
    TURGOR_TRY(const std::vector<double> errors, search.farm_errors(units));
    // Those after the first that rests are as if they had not been: their number is that of the threads.
    for (std::size_t i = 0; i < units.size() && !search.has_best(); ++i) {
      if (std::isnan(errors[i])) return Error{ErrorKind::cancelled, "stopped on request"};
      search.record(FitSample::Stage::search, units[i], errors[i]);
    }
  }
  return {};
}

}  // namespace

Result<void> sample_coarsely(Search& search) {
  const auto units =
      latin_hypercube(search.options().coarse_samples, search.space().size(), search.options().seed);
  // In pieces, so that progress shows.
  const auto piece = static_cast<std::size_t>(4 * std::max(search.farm_width(), 1));
  for (std::size_t begin = 0; begin < units.size(); begin += piece) {
    const std::size_t count = std::min(piece, units.size() - begin);
    TURGOR_CHECK(search.evaluate(FitSample::Stage::coarse, std::span(units).subspan(begin, count)));
  }
  return sample_until_one_rests(search);
}

}  // namespace turgor
