#include "grtx/modules/kernel/crowded_host.h"

#include <pthread.h>

#include <algorithm>

namespace grtx::modules {
namespace {

using namespace std::chrono_literals;

// Share of the time in which all threads have a core. Below it two threads are slower than one; on a quiet host they
// are 1.6 times as fast.
constexpr double kTogether = 0.6;
constexpr auto kLook = 20ms;  // several time slices of the host's scheduler
constexpr auto kFirstRest = 1s;
constexpr auto kLongestRest = 64s;

std::chrono::nanoseconds processor_time(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

}  // namespace

CrowdedHost::CrowdedHost() { watch(pthread_self()); }

void CrowdedHost::watch(std::thread& worker) { watch(worker.native_handle()); }

void CrowdedHost::watch(pthread_t thread) {
  clockid_t clock{};
  if (pthread_getcpuclockid(thread, &clock) == 0) threads_.push_back({clock});
}

void CrowdedHost::begin() {
  began_ = Clock::now();
  look(began_);
}

void CrowdedHost::look(Clock::time_point now) {
  looking_since_ = now;
  for (Thread& thread : threads_) thread.had = processor_time(thread.clock);
}

bool CrowdedHost::crowded() {
  const Clock::time_point now = Clock::now();
  const Clock::duration wall = now - looking_since_;
  if (wall < kLook) return false;
  double together = 1.0;
  for (const Thread& thread : threads_) {
    const auto had = std::chrono::duration<double>(processor_time(thread.clock) - thread.had);
    together *= had / std::chrono::duration<double>(wall);
  }
  look(now);
  if (together >= kTogether) return false;
  rest_ = now - began_ < rest_ ? std::min<Clock::duration>(2 * rest_, kLongestRest) : kFirstRest;
  again_ = now + rest_;
  return true;
}

}  // namespace grtx::modules
