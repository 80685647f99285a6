// How far a clock domain on a thread of its own has come, and how others wait for it.
#pragma once

#include <atomic>
#include <chrono>
#include <exception>
#include <thread>

#include "grtx/base/strong.h"

namespace grtx::modules {

/// Thrown to a thread that waits for one that has ended.
struct ThreadStopped final : std::exception {
  const char* what() const noexcept override { return "the simulation has stopped"; }
};

/// How long a thread waits before it gives its core to others.
struct Patience {
  unsigned spins = 2000;  ///< 0: at once, for hosts with fewer cores than threads
};

/// How many more times this thread sleeps instead of yielding its core, on a crowded host.
inline thread_local unsigned crowded = 0;

/// Spins, since most waits are far shorter than a call of the operating system; then leaves the core to others, which
/// may be the ones that it waits for. On a crowded host somebody else takes it and keeps it for milliseconds: a thread
/// that has just slept gets it back sooner than one that has given it up.
template <typename Ready>
void wait_until(Patience patience, Ready&& ready) {
  constexpr unsigned kYields = 20'000;
  using Clock = std::chrono::steady_clock;
  unsigned tries = 0;
  for (unsigned i = 0; !ready(); ++i) {
    if (i >= patience.spins && (crowded > 0 || tries >= kYields)) {
      std::this_thread::sleep_for(std::chrono::microseconds(20));
      if (crowded > 0) --crowded;
    } else if (i >= patience.spins) {
      const Clock::time_point before = Clock::now();
      std::this_thread::yield();
      ++tries;
      if (Clock::now() - before > std::chrono::milliseconds(1)) crowded = 200;
    } else {
#if defined(__x86_64__) || defined(__i386__)
      __builtin_ia32_pause();
#endif
    }
  }
}

/// Written by one thread. In a line of the host's cache of its own.
class alignas(64) ThreadProgress {
 public:
  /// Cycles below this one are done: all that was sent in them has been sent, all that was taken has been taken.
  Cycle cycles() const { return cycles_.load(std::memory_order_acquire); }
  void publish(Cycle cycles) {
    if (cycles > cycles_.load(std::memory_order_relaxed)) cycles_.store(cycles, std::memory_order_release);
  }
  /// Throws ThreadStopped when stop() is called first.
  void wait_for(Cycle cycles, Patience patience) const {
    wait_until(patience, [&] { return this->cycles() >= cycles || stopped_.load(std::memory_order_relaxed); });
    if (this->cycles() < cycles) throw ThreadStopped();
  }
  /// Nobody is to wait any longer.
  void stop() { stopped_.store(true, std::memory_order_relaxed); }

 private:
  std::atomic<Cycle> cycles_{0};
  std::atomic<bool> stopped_{false};
};

}  // namespace grtx::modules
