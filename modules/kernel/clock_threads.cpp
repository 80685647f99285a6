#include "grtx/modules/kernel/clock_threads.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace grtx::modules {
namespace {

// Cycles by which a follower may pass the next slowest one of its thread before that one is stepped.
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
    if (!t.thread.joinable()) continue;
    if (t.rest.load() % 2 != 0) {
      t.rest.fetch_add(1);
      t.rest.notify_one();
    }
    t.thread.join();
  }
}

const ThreadProgress& ClockThreads::follow(ClockDomain& domain, unsigned thread) {
  assert(!started_ && thread < threads_.size() && domain.period_fs() == domain_.period_fs());
  domain.followed_ = true;
  followers_.push_back(std::make_unique<Follower>(domain, thread));
  threads_[thread].own.push_back(followers_.back().get());
  threads_[thread].order = threads_[thread].own;
  return followers_.back()->progress;
}

// Called once the simulation has started: before that the kernel's thread sets the alarms of all domains.
void ClockThreads::start() {
  started_ = true;
  for (std::size_t t = 1; t < threads_.size(); ++t) {
    threads_[t].thread = std::thread([this, &thread = threads_[t]] { run(thread); });
    host_.watch(threads_[t].thread);
  }
  host_.begin();
}

void ClockThreads::allow(Cycle limit) { limit_.store(limit, std::memory_order_release); }

void ClockThreads::check() const {
  if (failed_.load(std::memory_order_acquire)) std::rethrow_exception(failure_);
}

// Rereads the progress of threads last seen at `up_to` or earlier. Returns the slowest progress.
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

// The leader's own followers go on while the leader waits.
void ClockThreads::wait() {
  publish(horizon_ + lag_);
  if (step(threads_[0], leader_.cycles(), limit_.load(std::memory_order_relaxed))) return;
  std::uint64_t waited = 0;
  const bool long_wait = wait_until([&] {
    ++waited;
    return look(horizon_) != horizon_ || failed_.load(std::memory_order_relaxed);
  });
  threads_[0].waits(waited - 1);
  check();
  if (long_wait && crowded()) rest();
}

// The workers stop after their current step, and the leader's thread takes over all their followers.
void ClockThreads::rest() {
  Thread& leader = threads_[0];
  for (std::size_t t = 1; t < threads_.size(); ++t) threads_[t].rest.fetch_add(1);
  for (std::size_t t = 1; t < threads_.size(); ++t) {
    Thread& worker = threads_[t];
    wait_until([&] {
      return worker.rests.load(std::memory_order_acquire) == worker.rest.load(std::memory_order_relaxed) ||
             failed_.load(std::memory_order_relaxed);
    });
    check();
    leader.own.insert(leader.own.end(), worker.own.begin(), worker.own.end());
    worker.own.clear();
    worker.order.clear();
  }
  leader.order = leader.own;
  std::sort(leader.order.begin(), leader.order.end(),
            [](const Follower* a, const Follower* b) { return a->progress.cycles() < b->progress.cycles(); });
  for (const Follower* follower : leader.own) follower->coupling->collect_for_leader();  // as Thread::seen requires
  leader.seen = leader.order.front()->progress.cycles();
  leader.progress.set(leader.seen);
  rested_ = true;
}

// Ends the rest. Called while all threads stand still.
void ClockThreads::wake() {
  for (Thread& thread : threads_) thread.own.clear();
  for (auto& follower : followers_) threads_[follower->home].own.push_back(follower.get());
  for (Thread& thread : threads_) {
    thread.order = thread.own;
    thread.progress.publish(horizon_);
    thread.seen = horizon_;
  }
  for (std::size_t t = 1; t < threads_.size(); ++t) {
    threads_[t].rest.fetch_add(1, std::memory_order_release);
    threads_[t].rest.notify_one();
  }
  host_.begin();
}

void ClockThreads::stepped(Cycle cycle) {
  // The limit first, then the progress: a thread that sees the progress also sees the limit.
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
    wait_until([&] {
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

// Whether all workers have read the limit. The end of a run lowers it, so a thread may already be beyond it.
bool ClockThreads::all_obey(Cycle limit) const {
  return resting() || std::all_of(threads_.begin() + 1, threads_.end(), [limit](const Thread& thread) {
           return thread.obeys.load(std::memory_order_acquire) == limit;
         });
}

// Called while all threads stand still. A worker keeps at least one follower; the leader's thread may have none.
void ClockThreads::balance() {
  if (resting()) {
    if (judge_ ? !judge_() : host_.may_try_again()) wake();
    return;
  }
  if (crowded()) return rest();
  Thread* most = nullptr;
  Thread* least = nullptr;
  for (Thread& thread : threads_) {
    if (most == nullptr || thread.waits_so_far() > most->waits_so_far()) most = &thread;
    const bool gives = thread.own.size() > (&thread == threads_.data() ? 0 : 1);
    if (gives && (least == nullptr || thread.waits_so_far() < least->waits_so_far())) least = &thread;
  }
  if (least != nullptr && least->waits_so_far() < most->waits_so_far()) {
    most->own.push_back(least->own.back());
    least->own.pop_back();
    for (Thread* thread : {most, least}) thread->order = thread->own;
    most->progress.publish(horizon_);  // its progress is stale if it had no follower
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

// Steps the follower through the cycles below `up_to`, as far as their input is complete.
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
      // This step may have changed how soon the leader can send to it.
      known = std::max(next + 1, std::min(known, leader + follower.coupling->reach()));
    }
    follower.progress.publish(done = std::min(domain.next_, known));
  }
}

// Steps the slowest follower of the thread that can go on. Returns whether there was one.
bool ClockThreads::step(Thread& thread, Cycle leader, Cycle limit) {
  if (thread.progress.cycles() >= limit) return false;  // at the limit, the leader's thread may access all domains
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
    if (const unsigned rest = thread.rest.load(std::memory_order_acquire); rest % 2 != 0) {
      thread.rests.store(rest, std::memory_order_release);
      thread.rest.wait(rest);
      continue;
    }
    if (limit != thread.obeys.load(std::memory_order_relaxed)) thread.obeys.store(limit, std::memory_order_release);
    if (step(thread, leader, limit)) continue;
    // The leader's progress is read only when no work is left, since its cache line belongs to another thread.
    std::uint64_t waited = 0;
    wait_until([&] {
      ++waited;
      return leader_.cycles() != leader || limit_.load(std::memory_order_relaxed) != limit ||
             thread.rest.load(std::memory_order_relaxed) % 2 != 0 || stop_.load(std::memory_order_relaxed);
    });
    thread.waits(waited - 1);
    leader = leader_.cycles();
  }
}

}  // namespace grtx::modules
