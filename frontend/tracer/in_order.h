// SPDX-License-Identifier: Apache-2.0
// Runs a function for indices 0 to n on several threads. Threads take indices in ascending order, so a call that waits
// for all earlier ones waits for at most threads - 1 calls that are still running.
#pragma once

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <cstddef>

namespace grtx::frontend {

/// Calls f(i) for i in [0, count) on up to `threads` threads (0: all). No index is taken before all below it are taken.
/// When a call throws, no further index is taken, and the exception comes out when the calls under way have ended.
template <typename F>
void for_each_in_order(std::size_t count, unsigned threads, const F& f) {
  std::atomic<std::size_t> next{0};
  tbb::task_arena arena(threads == 0 ? tbb::task_arena::automatic : static_cast<int>(threads));
  arena.execute([&] {
    tbb::parallel_for(
        0, tbb::this_task_arena::max_concurrency(),
        [&](int) {
          try {
            for (std::size_t i = next++; i < count; i = next++) f(i);
          } catch (...) {
            next = count;
            throw;
          }
        },
        tbb::simple_partitioner());
  });
}

}  // namespace grtx::frontend
