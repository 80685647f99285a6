#include "grtx/modules/kernel/clock_threads.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace grtx::modules {
namespace {

// Cycles by which a domain passes the next slowest of its thread before that has its turn.
constexpr Cycle kTurn = 8;

}  // namespace

ClockThreads::ClockThreads(ClockDomain& leader, Cycle lag, unsigned workers)
    : domain_(leader), lag_(lag), threads_(1 + workers) {
  assert(lag >= 1);
  domain_.threads_ = this;
}

ClockThreads::~ClockThreads() {
  domain_.threads_ = nullptr;
  stop_.store(true);
  leader_.stop();
  for (auto& follower : followers_) follower->progress.stop();
  for (Thread& t : threads_) {
    if (t.thread.joinable()) t.thread.join();
  }
}

const ThreadProgress& ClockThreads::follow(ClockDomain& domain, unsigned thread) {
  assert(!started_ && thread < threads_.size() && domain.period_fs() == domain_.period_fs());
  domain.followed_ = true;
  followers_.push_back(std::make_unique<Follower>(domain));
  threads_[thread].own.push_back(followers_.back().get());
  threads_[thread].order = threads_[thread].own;
  return followers_.back()->progress;
}

// Not before the simulation has started: until then the kernel's thread sets alarms of all domains.
void ClockThreads::start() {
  started_ = true;
  for (std::size_t t = 1; t < threads_.size(); ++t) {
    threads_[t].thread = std::thread([this, &thread = threads_[t]] { run(thread); });
  }
}

void ClockThreads::allow(Cycle limit) { limit_.store(limit, std::memory_order_release); }

void ClockThreads::check() const {
  if (failed_.load(std::memory_order_acquire)) std::rethrow_exception(failure_);
}

// Looks again at the threads that were last seen not to be beyond this cycle. Returns the slowest.
Cycle ClockThreads::look(Cycle up_to) {
  Cycle slowest = kNever;
  for (Thread& thread : threads_) {
    if (thread.own.empty()) continue;
    if (thread.seen <= up_to) {
      if (const Cycle now = thread.progress.cycles(); now != thread.seen) {
        thread.seen = now;
        for (const Follower* follower : thread.own) follower->coupling->collect_for_leader();
      }
    }
    slowest = std::min(slowest, thread.seen);
  }
  return slowest;
}

Cycle ClockThreads::sure(Cycle wanted) {
  if (!started_) start();
  if (wanted >= horizon_ + lag_) horizon_ = look(horizon_);
  return horizon_ + lag_;
}

// What is the leader's thread's own may go on as long as the leader does not, and need not be asked again then.
void ClockThreads::wait() {
  publish(horizon_ + lag_);
  if (step(threads_[0], leader_.cycles(), limit_.load(std::memory_order_relaxed))) return;
  std::uint64_t waited = 0;
  wait_until(patience_, [&] {
    ++waited;
    return look(horizon_) != horizon_ || failed_.load(std::memory_order_relaxed);
  });
  threads_[0].waits(waited - 1);
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
    while (step(threads_[0], limit, limit)) {
    }
    wait_until(patience_, [&] {
      horizon_ = look(limit);
      return (horizon_ >= limit && all_obey(limit)) || failed_.load(std::memory_order_relaxed);
    });
    check();
    if (limit > 0) {
      domain_.advance(limit - 1);
      for (auto& follower : followers_) follower->domain.advance(limit - 1);
    }
    balance();
  }
  return leader_.cycles();
}

// A thread may be past the limit when the end of the run has lowered it, and not know that yet.
bool ClockThreads::all_obey(Cycle limit) const {
  return std::all_of(threads_.begin() + 1, threads_.end(),
                     [limit](const Thread& thread) { return thread.obeys.load(std::memory_order_acquire) == limit; });
}

// While all stand still. The leader's thread may be left without a domain, others are not.
void ClockThreads::balance() {
  Thread* most = nullptr;
  Thread* least = nullptr;
  for (Thread& thread : threads_) {
    const bool leads = &thread == threads_.data();
    const bool takes = !leads || leader_takes_part_;
    if (takes && (most == nullptr || thread.waits_so_far() > most->waits_so_far())) most = &thread;
    const bool gives = thread.own.size() > (leads ? 0 : 1);
    if (gives && (least == nullptr || thread.waits_so_far() < least->waits_so_far())) least = &thread;
  }
  if (least != nullptr && least->waits_so_far() < most->waits_so_far()) {
    most->own.push_back(least->own.back());
    least->own.pop_back();
    for (Thread* thread : {most, least}) thread->order = thread->own;
    most->progress.publish(horizon_);  // it may have had none
    most->seen = horizon_;
  }
  for (Thread& thread : threads_) thread.waited.store(0, std::memory_order_relaxed);
}

void ClockThreads::run(Thread& thread) {
  try {
    work(thread);
  } catch (const ThreadStopped&) {
    // the run is over
  } catch (...) {
    if (!failing_.exchange(true)) {
      failure_ = std::current_exception();
      failed_.store(true, std::memory_order_release);
    }
  }
}

// Steps the follower to before `up_to`, or as far as is known.
void ClockThreads::step(Follower& follower, Cycle leader, Cycle limit, Cycle up_to) {
  Cycle done = follower.progress.cycles();
  if (done >= up_to) return;
  follower.coupling->collect();
  Cycle known = std::min({limit, up_to, leader + follower.coupling->reach()});
  ClockDomain& domain = follower.domain;
  while (done < known) {
    const Cycle next = domain.next_;
    if (next < known) {
      if (next > done) follower.progress.publish(done = next);
      if (!follower.coupling->knows_room(next)) return;
      domain.step();
      // What has happened may let others send to it sooner.
      known = std::max(next + 1, std::min(known, leader + follower.coupling->reach()));
    }
    follower.progress.publish(done = std::min(domain.next_, known));
  }
}

// The slowest that may go on. Returns whether there was one.
bool ClockThreads::step(Thread& thread, Cycle leader, Cycle limit) {
  if (thread.progress.cycles() >= limit) return false;  // stands still: the leader's thread may look at everything
  std::vector<Follower*>& order = thread.order;
  for (std::size_t i = 0; i < order.size(); ++i) {
    Follower* const follower = order[i];
    const Cycle before = follower->progress.cycles();
    const Cycle next = i + 1 < order.size() ? order[i + 1]->progress.cycles() : before;
    step(*follower, leader, limit, next + kTurn);
    const Cycle done = follower->progress.cycles();
    if (done == before) continue;
    std::size_t at = i;
    for (; at + 1 < order.size() && order[at + 1]->progress.cycles() < done; ++at) order[at] = order[at + 1];
    order[at] = follower;
    thread.progress.publish(order.front()->progress.cycles());
    return true;
  }
  return false;
}

void ClockThreads::work(Thread& thread) {
  Cycle leader = 0;
  while (!stop_.load(std::memory_order_relaxed)) {
    const Cycle limit = limit_.load(std::memory_order_acquire);
    if (limit != thread.obeys.load(std::memory_order_relaxed)) thread.obeys.store(limit, std::memory_order_release);
    if (step(thread, leader, limit)) continue;
    // Looked at only when nothing is left to do: the line of the host's cache is another thread's.
    std::uint64_t waited = 0;
    wait_until(patience_, [&] {
      ++waited;
      return leader_.cycles() != leader || limit_.load(std::memory_order_relaxed) != limit ||
             stop_.load(std::memory_order_relaxed);
    });
    thread.waits(waited - 1);
    leader = leader_.cycles();
  }
}

}  // namespace grtx::modules
