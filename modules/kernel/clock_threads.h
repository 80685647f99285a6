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
#include "grtx/modules/kernel/crossing_link.h"
#include "grtx/modules/kernel/thread_progress.h"

namespace grtx::modules {

/// No windows and no barriers: each thread publishes how far it has come, and works on a cycle as soon as everything
/// that can be visible in it has been sent. So the threads are apart by as much as the links' latencies allow, and
/// results do not depend on who is faster. The leading domain (ClockDomain, RunAhead) calls what is said to be its.
class ClockThreads {
 public:
  /// What a following thread may know before it asks: called by that thread between two cycles, after its inboxes were
  /// looked at. Cycles below (the leader's progress + reach) have all their input. At least 1.
  using Reach = std::function<Cycle()>;

  /// lag: what a follower sends in a cycle is visible to the leader so many cycles later, or more.
  ClockThreads(ClockDomain& leader, Cycle lag);
  ~ClockThreads();
  ClockThreads(const ClockThreads&) = delete;
  ClockThreads& operator=(const ClockThreads&) = delete;

  /// Before the simulation starts. domain: of the leader's frequency, ticked by a thread of its own from now on.
  /// Returns the follower's number.
  unsigned follow(ClockDomain& domain, Reach reach);
  /// How each thread waits for others; before the simulation starts.
  void be_patient(Patience patience) { patience_ = patience; }
  const ThreadProgress& leader_progress() const { return leader_; }
  const ThreadProgress& progress(unsigned follower) const { return followers_[follower]->progress; }
  void add_leader_inbox(Inbox& inbox) { leader_inboxes_.push_back(&inbox); }
  void add_inbox(unsigned follower, Inbox& inbox) { followers_[follower]->inboxes.push_back(&inbox); }
  /// Asked after each cycle of the leader until it says true: no thread works on a later cycle before allow().
  void stop_when(std::function<bool()> ended) { ended_ = std::move(ended); }

  // The leader's thread.
  /// Cycles below `limit` may be worked on.
  void allow(Cycle limit);
  /// The leader's cycles below have all their input, which its inboxes have collected.
  Cycle sure();
  /// Until sure() is larger than now; the leader has nothing to do before. Throws what a follower has thrown.
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
    Follower(ClockDomain& of, Reach up_to) : domain(of), reach(std::move(up_to)) {}
    ClockDomain& domain;
    Reach reach;
    std::vector<Inbox*> inboxes;
    ThreadProgress progress;
    std::thread thread;
  };

  void start();
  void run(Follower& follower);
  void work(Follower& follower);
  Cycle slowest() const;
  void check() const;

  ClockDomain& domain_;
  Cycle lag_;
  Patience patience_;
  std::function<bool()> ended_;
  std::vector<Inbox*> leader_inboxes_;
  std::vector<std::unique_ptr<Follower>> followers_;
  ThreadProgress leader_;
  Cycle horizon_ = 0;  ///< the slowest follower, when the leader last looked
  bool started_ = false;
  std::exception_ptr failure_;  ///< of the follower that set failed_
  alignas(64) std::atomic<Cycle> limit_{0};
  std::atomic<bool> failing_{false};
  std::atomic<bool> failed_{false};  ///< failure_ may be read
  std::atomic<bool> stop_{false};
};

}  // namespace grtx::modules
