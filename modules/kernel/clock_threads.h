// Clock domains on threads of their own beside the one that the kernel's thread ticks: the cores of the host for one
// simulation. All have one frequency and one count of cycles.
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

/// No windows and no barriers: each thread publishes how far it has come, and works on a cycle as soon as everything
/// that can be visible in it has been sent. So domains are apart by as much as the links' latencies allow, and results
/// do not depend on who is faster. A thread steps the domains that are its in turn; the leader's thread does so when
/// the leader has to wait. Whenever all stand still, a domain goes from the thread that waited least to the one that
/// waited most. While other programs take the host's cores, the workers rest and the leader's thread steps all domains.
/// The leading domain (ClockDomain, RunAhead) calls what is said to be its.
class ClockThreads {
 public:
  /// The links between a following domain and the leader.
  class Coupling {
   public:
    /// Takes note of what the leader has sent. By the thread that steps the domain, between two cycles.
    virtual void collect() = 0;
    /// Takes note of what the domain has sent. By the leader's thread.
    virtual void collect_for_leader() = 0;
    /// Cycles below (the leader's progress + reach) have all their input, if that progress was read before collect().
    /// At least 1.
    virtual Cycle reach() const = 0;
    /// Whether what the domain may send in this cycle is known to find room, or to find none.
    virtual bool knows_room(Cycle cycle) const = 0;

   protected:
    ~Coupling() = default;
  };

  /// lag: what a follower sends in a cycle is visible to the leader so many cycles later, or more.
  /// workers: threads beside the leader's.
  ClockThreads(ClockDomain& leader, Cycle lag, unsigned workers);
  ~ClockThreads();
  ClockThreads(const ClockThreads&) = delete;
  ClockThreads& operator=(const ClockThreads&) = delete;

  /// Before the simulation starts. domain: of the leader's frequency, no longer ticked by the kernel. thread: whose it
  /// is at first; 0: the leader's. Returns how far it has come. Followers are numbered from 0.
  const ThreadProgress& follow(ClockDomain& domain, unsigned thread);
  void couple(unsigned follower, Coupling& coupling) { followers_[follower]->coupling = &coupling; }
  /// Asked in the place of the host's clocks whether workers had better rest, or go on resting: at long waits, and
  /// where all stand still. Before the simulation starts; for tests.
  void judge_by(std::function<bool()> crowded) { judge_ = std::move(crowded); }
  /// Whether workers have ever rested.
  bool rested() const { return rested_; }
  const ThreadProgress& leader_progress() const { return leader_; }
  /// Asked after each cycle of the leader until it says true: nobody works on a later cycle before allow().
  void stop_when(std::function<bool()> ended) { ended_ = std::move(ended); }

  // The leader's thread.
  /// Cycles below `limit` may be worked on.
  void allow(Cycle limit);
  /// The leader's cycles below have all their input, which has been collected. Followers are looked at only when
  /// `wanted` is not below.
  Cycle sure(Cycle wanted);
  /// Until more may be sure; the leader has nothing to do before. Throws what a follower has thrown.
  void wait();
  /// The leader's cycles below are done.
  void publish(Cycle cycles) { leader_.publish(cycles); }
  /// The leader has done this cycle.
  void stepped(Cycle cycle);
  /// The leader has nothing to do below `next`. When all that is allowed has been done, waits for the others, which
  /// then stand still. Returns the first cycle that is not done.
  Cycle pause(Cycle next);

 private:
  struct Follower {
    Follower(ClockDomain& of, unsigned thread) : domain(of), home(thread) {}
    ClockDomain& domain;
    unsigned home;  ///< whose it is at first
    Coupling* coupling = nullptr;
    ThreadProgress progress;
  };
  /// What is the thread's, what others look at and what is the leader's lie in different lines of the host's cache.
  struct alignas(64) Thread {
    std::vector<Follower*> own;            ///< changed while all stand still
    std::vector<Follower*> order;          ///< the same, the slowest first
    std::atomic<std::uint64_t> waited{0};  ///< times that it found nothing to do since the last balance()
    std::atomic<Cycle> obeys{0};           ///< the limit that it knows; not the leader's
    std::atomic<unsigned> rest{0};         ///< odd: it is to rest
    std::atomic<unsigned> rests{0};        ///< since it saw this value of rest, which was odd
    ThreadProgress progress;               ///< the slowest of its own
    Cycle seen = 0;                        ///< by the leader: up to which all has been collected
    std::thread thread;                    ///< none: the leader's
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
  std::vector<Thread> threads_;  ///< the leader's first
  ThreadProgress leader_;
  Cycle horizon_ = 0;  ///< the slowest follower, when the leader last looked
  bool started_ = false;
  bool rested_ = false;
  CrowdedHost host_;
  std::function<bool()> judge_;  ///< in place of host_
  std::exception_ptr failure_;   ///< of the worker that set failed_
  alignas(64) std::atomic<Cycle> limit_{0};
  std::atomic<bool> failing_{false};
  std::atomic<bool> failed_{false};  ///< failure_ may be read
  std::atomic<bool> stop_{false};
};

}  // namespace grtx::modules
