// Published progress of a clock domain or thread, and how other threads wait for it.
#pragma once

#include <atomic>
#include <exception>
#include <thread>

#include "grtx/base/strong.h"

namespace grtx::modules {

/// Thrown in a thread that waits for one that has ended.
struct ThreadStopped final : std::exception {
  const char* what() const noexcept override { return "the simulation has stopped"; }
};

/// Waits until ready() is true. Spins first, since most waits are far shorter than a system call; then yields the core,
/// possibly to the thread it waits for. Returns whether it yielded.
template <typename Ready>
bool wait_until(Ready&& ready) {
  constexpr unsigned kSpins = 2000;
  for (unsigned i = 0; i < kSpins; ++i) {
    if (ready()) return false;
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#endif
  }
  while (!ready()) std::this_thread::yield();
  return true;
}

/// Written by one thread, read by others. Occupies a cache line of the host of its own.
class alignas(64) ThreadProgress {
 public:
  /// All cycles below this one are done, including their pushes and pops.
  Cycle cycles() const { return cycles_.load(std::memory_order_acquire); }
  void publish(Cycle cycles) {
    if (cycles > cycles_.load(std::memory_order_relaxed)) cycles_.store(cycles, std::memory_order_release);
  }
  /// Like publish(), but may also go back, after slower domains were added. Only while no other thread reads it.
  void set(Cycle cycles) { cycles_.store(cycles, std::memory_order_release); }
  /// Throws ThreadStopped when stop() is called first.
  void wait_for(Cycle cycles) const {
    wait_until([&] { return this->cycles() >= cycles || stopped_.load(std::memory_order_relaxed); });
    if (this->cycles() < cycles) throw ThreadStopped();
  }
  /// Ends all waits.
  void stop() { stopped_.store(true, std::memory_order_relaxed); }

 private:
  std::atomic<Cycle> cycles_{0};
  std::atomic<bool> stopped_{false};
};

}  // namespace grtx::modules
