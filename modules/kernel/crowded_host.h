// Whether the threads of one simulation get the cores of the host that they ask for.
#pragma once

#include <chrono>
#include <ctime>
#include <thread>
#include <vector>

namespace grtx::modules {

/// Threads that wait for each other every few microseconds come on only while all of them have a core. Where other
/// programs take cores for milliseconds, one thread alone is faster. A thread that works never sleeps, so what it lacks
/// of the wall time in processor time, it was without a core.
class CrowdedHost {
 public:
  /// The caller is one of the threads.
  CrowdedHost();
  void watch(std::thread& worker);
  /// The workers begin, or go on after a rest.
  void begin();
  /// Whether they had better rest. By the time since the last answer, if that was long enough to judge.
  bool crowded();
  /// Workers that rest are to try again. The time until then doubles while that is in vain.
  bool may_try_again() const { return Clock::now() >= again_; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Thread {
    clockid_t clock;
    Clock::duration had{};  ///< processor time when the look began
  };
  void watch(pthread_t thread);
  void look(Clock::time_point now);

  std::vector<Thread> threads_;
  Clock::time_point began_;  ///< to work
  Clock::time_point looking_since_;
  Clock::time_point again_;
  Clock::duration rest_ = Clock::duration::zero();
};

}  // namespace grtx::modules
