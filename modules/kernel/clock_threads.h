// Runs clock domains on several threads: the leader domain on the SystemC kernel's thread, follower domains on worker
// threads. All have the same frequency and cycle count.
#pragma once

#include <atomic>
#include <exception>
#include <functional>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/kernel/crowded_host.h"
#include "grtx/modules/kernel/thread_progress.h"

namespace grtx::modules {

/// No windows and no barriers: each thread publishes its progress, and processes a cycle as soon as everything that can
/// be visible in it has been sent. Domains therefore drift apart by up to the links' latencies, and results do not
/// depend on thread timing. A worker steps its followers in turn; the leader's thread steps its own while the leader
/// has to wait. At each limit (allow()), when all threads stand still, one follower moves from the thread that waited
/// least to the one that waited most. If other programs need the host's cores, the workers rest and the leader's thread
/// steps all domains.
class ClockThreads {
 public:
  /// The links between a following domain and the leader.
  class Coupling {
   public:
    /// Registers what the leader has sent. Called between two cycles by the thread that steps the follower.
    virtual void collect() = 0;
    /// Registers what the follower has sent. Called by the leader's thread.
    virtual void collect_for_leader() = 0;
    /// At least 1 cycle: all input of the cycles below (the leader's progress + reach) is there, if that progress was
    /// read before collect().
    virtual Cycle reach() const = 0;
    /// Whether it is already known if the links have room for what the follower may send in this cycle.
    virtual bool knows_room(Cycle cycle) const = 0;

   protected:
    ~Coupling() = default;
  };

  /// lag: least latency of the links from followers to the leader, in cycles. workers: threads beside the leader's.
  ClockThreads(ClockDomain& leader, Cycle lag, unsigned workers);
  ~ClockThreads();
  ClockThreads(const ClockThreads&) = delete;
  ClockThreads& operator=(const ClockThreads&) = delete;

  /// Adds a follower, numbered from 0; before the simulation starts. domain: must have the leader's frequency; the
  /// kernel no longer ticks it. thread: initial owner, 0 is the leader's thread. Returns the follower's progress.
  const ThreadProgress& follow(ClockDomain& domain, unsigned thread);
  void couple(unsigned follower, Coupling& coupling) { followers_[follower]->coupling = &coupling; }
  /// For tests, before the simulation starts: `crowded` decides instead of CrowdedHost whether workers rest. Asked
  /// after long waits and when all threads stand still.
  void judge_by(std::function<bool()> crowded) { judge_ = std::move(crowded); }
  /// Whether the workers have ever rested.
  bool rested() const { return rested_; }
  const ThreadProgress& leader_progress() const { return leader_; }
  /// `ended` is asked after each cycle of the leader until it returns true; then no domain goes beyond that cycle until
  /// allow() is called.
  void stop_when(std::function<bool()> ended) { ended_ = std::move(ended); }

  // The rest is called by the leading domain (ClockDomain, RunAhead) on the leader's thread.
  /// Allows all domains to process the cycles below `limit`.
  void allow(Cycle limit);
  /// Returns the first cycle of the leader whose input may still be incomplete; all input before it is collected. Reads
  /// the followers' progress only if `wanted` is not below the last known value.
  Cycle sure(Cycle wanted);
  /// Waits until sure() may return more; meanwhile steps the leader thread's own followers. Rethrows an exception of a
  /// follower.
  void wait();
  /// The leader has done all cycles below `cycles`.
  void publish(Cycle cycles) { leader_.publish(cycles); }
  /// The leader has done `cycle`.
  void stepped(Cycle cycle);
  /// The leader has no work before `next`. If the leader has reached the limit, waits until all followers have, too.
  /// Returns the first cycle that the leader has not done.
  Cycle pause(Cycle next);

 private:
  struct Follower {
    Follower(ClockDomain& of, unsigned thread) : domain(of), home(thread) {}
    ClockDomain& domain;
    unsigned home;  ///< thread that owns it at first and after a rest
    Coupling* coupling = nullptr;
    ThreadProgress progress;
  };
  /// Aligned so that two threads' entries share no cache line of the host.
  struct alignas(64) Thread {
    std::vector<Follower*> own;            ///< its followers; changed only while all threads stand still
    std::vector<Follower*> order;          ///< the same, slowest first
    std::atomic<std::uint64_t> waited{0};  ///< polls without work since the last balance()
    std::atomic<Cycle> obeys{0};           ///< the limit that the worker has read
    std::atomic<unsigned> rest{0};         ///< odd: the worker shall rest
    std::atomic<unsigned> rests{0};        ///< the odd value of `rest` that the worker last obeyed
    ThreadProgress progress;               ///< of its slowest follower
    Cycle seen = 0;                        ///< progress last read by the leader, which has collected all before it
    std::thread thread;                    ///< empty for the leader's
    void waits(std::uint64_t times) { waited.fetch_add(times, std::memory_order_relaxed); }
    std::uint64_t waits_so_far() const { return waited.load(std::memory_order_relaxed); }
  };

  void start();
  void run(Thread& thread);
  void work(Thread& thread);
  bool step(Thread& thread, Cycle leader, Cycle limit);
  static void step(Follower& follower, Cycle leader, Cycle limit, Cycle up_to);
  Cycle look(Cycle up_to);
  bool all_obey(Cycle limit) const;
  void balance();
  bool crowded() { return judge_ ? judge_() : host_.crowded(); }
  bool resting() const { return threads_[1].rest.load(std::memory_order_relaxed) % 2 != 0; }
  void rest();
  void wake();
  void check() const;

  ClockDomain& domain_;
  Cycle lag_;
  std::function<bool()> ended_;
  std::vector<std::unique_ptr<Follower>> followers_;
  std::vector<Thread> threads_;  ///< [0]: the leader's
  ThreadProgress leader_;
  Cycle horizon_ = 0;  ///< progress of the slowest follower, as last read by the leader
  bool started_ = false;
  bool rested_ = false;
  CrowdedHost host_;
  std::function<bool()> judge_;  ///< replaces host_ if set
  std::exception_ptr failure_;   ///< first exception of a worker
  alignas(64) std::atomic<Cycle> limit_{0};
  std::atomic<bool> failing_{false};
  std::atomic<bool> failed_{false};  ///< failure_ may be read
  std::atomic<bool> stop_{false};
};

}  // namespace grtx::modules
