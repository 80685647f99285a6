// How far a clock domain on a thread of its own has come, and how others wait for it.
#pragma once

#include <atomic>
#include <exception>
#include <thread>

#include "grtx/base/strong.h"

namespace grtx::modules {

/// Thrown to a thread that waits for one that has ended.
struct ThreadStopped final : std::exception {
  const char* what() const noexcept override { return "the simulation has stopped"; }
};

/// Spins, since most waits are far shorter than a call of the operating system; then leaves the core to others, which
/// may be the ones that it waits for. Returns whether it came to that.
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

/// Written by one thread. In a line of the host's cache of its own.
class alignas(64) ThreadProgress {
 public:
  /// Cycles below this one are done: all that was sent in them has been sent, all that was taken has been taken.
  Cycle cycles() const { return cycles_.load(std::memory_order_acquire); }
  void publish(Cycle cycles) {
    if (cycles > cycles_.load(std::memory_order_relaxed)) cycles_.store(cycles, std::memory_order_release);
  }
  /// Others are added to those whose progress this is. While nobody else looks.
  void set(Cycle cycles) { cycles_.store(cycles, std::memory_order_release); }
  /// Throws ThreadStopped when stop() is called first.
  void wait_for(Cycle cycles) const {
    wait_until([&] { return this->cycles() >= cycles || stopped_.load(std::memory_order_relaxed); });
    if (this->cycles() < cycles) throw ThreadStopped();
  }
  /// Nobody is to wait any longer.
  void stop() { stopped_.store(true, std::memory_order_relaxed); }

 private:
  std::atomic<Cycle> cycles_{0};
  std::atomic<bool> stopped_{false};
};

}  // namespace grtx::modules
