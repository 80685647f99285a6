#include "grtx/modules/kernel/clock_threads.h"

#include <algorithm>
#include <cassert>

namespace grtx::modules {

ClockThreads::ClockThreads(ClockDomain& leader, Cycle lag) : domain_(leader), lag_(lag) {
  assert(lag >= 1);
  domain_.threads_ = this;
}

ClockThreads::~ClockThreads() {
  domain_.threads_ = nullptr;
  stop_.store(true);
  leader_.stop();
  for (auto& follower : followers_) follower->progress.stop();
  for (auto& follower : followers_) {
    if (follower->thread.joinable()) follower->thread.join();
  }
}

unsigned ClockThreads::follow(ClockDomain& domain, Reach reach) {
  assert(!started_ && domain.period_fs() == domain_.period_fs());
  domain.followed_ = true;
  followers_.push_back(std::make_unique<Follower>(domain, std::move(reach)));
  return static_cast<unsigned>(followers_.size() - 1);
}

// Not before the simulation has started: until then the kernel's thread sets alarms of all domains.
void ClockThreads::start() {
  started_ = true;
  for (auto& follower : followers_) follower->thread = std::thread([this, &f = *follower] { run(f); });
}

void ClockThreads::allow(Cycle limit) { limit_.store(limit, std::memory_order_release); }

Cycle ClockThreads::slowest() const {
  Cycle slowest = kNever;
  for (const auto& follower : followers_) slowest = std::min(slowest, follower->progress.cycles());
  return slowest;
}

void ClockThreads::check() const {
  if (failed_.load(std::memory_order_acquire)) std::rethrow_exception(failure_);
}

Cycle ClockThreads::sure() {
  if (!started_) start();
  if (const Cycle now = slowest(); now != horizon_) {
    horizon_ = now;
    for (Inbox* inbox : leader_inboxes_) inbox->collect();
  }
  return horizon_ + lag_;
}

void ClockThreads::wait() {
  publish(horizon_ + lag_);
  wait_until(patience_, [this] { return slowest() != horizon_ || failed_.load(std::memory_order_relaxed); });
  check();
}

void ClockThreads::stepped(Cycle cycle) {
  // In this order: who sees the progress sees the limit.
  if (ended_ && ended_()) {
    ended_ = nullptr;
    limit_.store(cycle + 1, std::memory_order_release);
  }
  publish(cycle + 1);
}

Cycle ClockThreads::pause(Cycle next) {
  const Cycle limit = limit_.load(std::memory_order_relaxed);
  if (std::min(next, horizon_ + lag_) >= limit) publish(limit);
  if (leader_.cycles() >= limit) {
    wait_until(patience_, [&] { return slowest() >= limit || failed_.load(std::memory_order_relaxed); });
    check();
    sure();
    if (limit > 0) {
      domain_.advance(limit - 1);
      for (auto& follower : followers_) follower->domain.advance(limit - 1);
    }
  }
  return leader_.cycles();
}

void ClockThreads::run(Follower& follower) {
  try {
    work(follower);
  } catch (const ThreadStopped&) {
    // the run is over
  } catch (...) {
    if (!failing_.exchange(true)) {
      failure_ = std::current_exception();
      failed_.store(true, std::memory_order_release);
    }
  }
}

void ClockThreads::work(Follower& follower) {
  ClockDomain& domain = follower.domain;
  while (!stop_.load(std::memory_order_relaxed)) {
    const Cycle leader = leader_.cycles();
    const Cycle limit = limit_.load(std::memory_order_acquire);
    const auto changed = [&] {
      return limit_.load(std::memory_order_relaxed) != limit || stop_.load(std::memory_order_relaxed);
    };
    if (follower.progress.cycles() >= limit) {  // stands still: the leader's thread may look at everything
      wait_until(patience_, changed);
      continue;
    }
    for (Inbox* inbox : follower.inboxes) inbox->collect();
    const Cycle known = std::min(limit, leader + follower.reach());
    if (const Cycle next = domain.next_; next < known) {
      follower.progress.publish(next);
      domain.step();
      follower.progress.publish(next + 1);
    } else {
      follower.progress.publish(known);
      wait_until(patience_, [&] { return leader_.cycles() != leader || changed(); });
    }
  }
}

}  // namespace grtx::modules
