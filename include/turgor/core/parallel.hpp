// Parallel loops and reductions that give the same bits on any number of threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <type_traits>
#include <vector>

namespace turgor {

/// Threads used by parallel_for: all cores, unless set_thread_count() said otherwise (0 restores the
/// default).
int thread_count();
void set_thread_count(int count);

namespace detail {
void parallel_chunks(std::size_t chunks, const std::function<void(std::size_t)>& body);
}  // namespace detail

/// Calls body(begin, end) for consecutive ranges of at most `grain` items. The ranges depend on `count` and
/// `grain` alone, never on the number of threads. One range runs inline without any scheduling.
template <class Body>
void parallel_for(std::size_t count, std::size_t grain, Body&& body) {
  if (count == 0) return;
  grain = std::max<std::size_t>(grain, 1);
  const std::size_t chunks = (count + grain - 1) / grain;
  if (chunks == 1 || thread_count() == 1) {
    for (std::size_t c = 0; c < chunks; ++c) body(c * grain, std::min(count, (c + 1) * grain));
    return;
  }
  detail::parallel_chunks(chunks, [&](std::size_t c) { body(c * grain, std::min(count, (c + 1) * grain)); });
}

/// Sum (or any fold) of partial(begin, end) over the ranges of parallel_for, combined in order of the ranges.
template <class T, class Partial, class Combine>
T parallel_reduce(std::size_t count, std::size_t grain, T identity, Partial&& partial, Combine&& combine) {
  if (count == 0) return identity;
  grain = std::max<std::size_t>(grain, 1);
  std::vector<T> parts((count + grain - 1) / grain, identity);
  parallel_for(count, grain,
               [&](std::size_t begin, std::size_t end) { parts[begin / grain] = partial(begin, end); });
  T total = identity;
  for (const T& part : parts) total = combine(total, part);
  return total;
}

/// Sum of term(i) over `count` items: the bits depend on `count` and `grain` alone.
template <class Term>
double parallel_sum(std::size_t count, std::size_t grain, Term&& term) {
  return parallel_reduce<double>(
      count, grain, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i) sum += term(i);
        return sum;
      },
      std::plus<>());
}

}  // namespace turgor
