// Detects whether the threads of a simulation get a core each, or compete with other programs for the host.
#pragma once

#include <chrono>
#include <ctime>
#include <thread>
#include <vector>

namespace grtx::modules {

/// Threads that wait for each other every few microseconds make progress only while all of them have a core. If other
/// programs take cores for milliseconds, a single thread is faster. Working threads spin instead of sleeping, so the
/// difference between wall time and processor time is time without a core.
class CrowdedHost {
 public:
  /// Also watches the calling thread.
  CrowdedHost();
  void watch(std::thread& worker);
  /// The workers start, or continue after a rest.
  void begin();
  /// Whether the workers should rest, judged over the time since the last judgement; false if that is under 20 ms.
  bool crowded();
  /// Whether resting workers should try again. The rest doubles with each failed attempt, 1 s to 64 s.
  bool may_try_again() const { return Clock::now() >= again_; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Thread {
    clockid_t clock;
    Clock::duration had{};  ///< its processor time at looking_since_
  };
  void watch(pthread_t thread);
  void look(Clock::time_point now);

  std::vector<Thread> threads_;
  Clock::time_point began_;  ///< last begin()
  Clock::time_point looking_since_;
  Clock::time_point again_;
  Clock::duration rest_ = Clock::duration::zero();
};

}  // namespace grtx::modules
