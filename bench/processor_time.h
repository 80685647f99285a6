// SPDX-License-Identifier: Apache-2.0
// Processor time: other work of the host lengthens it less than wall time.
#pragma once

#include <ctime>

namespace grtx::bench {

/// Seconds of this process or, with CLOCK_THREAD_CPUTIME_ID, of this thread.
inline double cpu_seconds(clockid_t clock = CLOCK_PROCESS_CPUTIME_ID) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace grtx::bench
