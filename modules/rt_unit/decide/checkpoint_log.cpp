#include "grtx/modules/rt_unit/decide/checkpoint_log.h"

#include <cassert>

namespace grtx::modules {

const CounterTable<CheckpointLog::Counters>& CheckpointLog::Counters::table() {
  using C = CheckpointLog::Counters;
  static const CounterTable<C> table =
      CounterTable<C>()

          .sum(&C::runs_written, "runs_written", "entries", "run entries written in place of forwarded entries")
          .sum(&C::runs_read, "runs_read", "entries", "run entries read")
          .sum(&C::runs_left, "runs_left", "entries", "run entries that nobody reads")
          .sum(&C::entries_referenced, "entries_referenced", "entries",
               "forwarded entries that a run entry names and that are not written again")
          .sum(&C::references_read, "references_read", "entries", "entries read by way of a run entry")
          .sum(&C::references_left, "references_left", "entries", "entries named by run entries that nobody reads")
          .sum(&C::copies_forced, "copies_forced", "entries", "forwarded entries too old to be named, written again");
  return table;
}

void CheckpointLog::begin(bool first, bool replays, std::uint64_t capacity, bool lifo) {
  assert(announced_.empty() && pending_.count == 0);
  // Nobody will read the entries that the last round left unread; nor, unless this one replays, those that it wrote.
  lifo_ ? leave(runs_, 0, unread_) : leave(runs_, unread_, runs_.size());
  if (!replays) leave(written_, 0, written_.size());
  lifo_ = lifo;
  capacity_ = capacity;
  runs_.clear();
  begin_ = end_ = 0;
  if (replays) {
    runs_.swap(written_);
    begin_ = written_from_;
    end_ = head_;
  }
  if (first) head_ = assigned_ = 0;
  unread_ = lifo_ ? runs_.size() : 0;
  reading_ = {};
  begun_ = false;
  written_.clear();
  written_from_ = head_;
}

unsigned CheckpointLog::close_run() {
  if (pending_.count == 0) return 0;
  const bool run = pending_.count > 1;
  if (run) {
    written_.push_back({assigned_, pending_});
    ++counters_.runs_written;
    counters_.entries_referenced += pending_.count;
  }
  ++assigned_;
  announced_.push(run ? 1 : 0);
  pending_ = {};
  return 1;
}

unsigned CheckpointLog::submit(unsigned entries, bool forwarded, bool last) {
  unsigned items = 0;
  if (forwarded && entries != 0) {
    // A copy or run entry that closes the run before takes a place first.
    const bool follows = pending_.count == 1 ? position_ == pending_.first + 1 || position_ + 1 == pending_.first
                                             : pending_.count > 1 && position_ == pending_.position(pending_.count);
    if (follows && assigned_ - position_ <= capacity_) {
      if (pending_.count++ == 1) pending_.step = position_ > pending_.first ? 1 : -1;
    } else {
      items += close_run();
      if (assigned_ - position_ <= capacity_) {
        pending_ = {position_, 1, 1};
      } else {
        ++counters_.copies_forced;
        ++assigned_;
        announced_.push(0);
        ++items;
      }
    }
  } else if (entries != 0) {
    items += close_run() + entries;
    assigned_ += entries;
    for (unsigned i = 0; i < entries; ++i) announced_.push(0);
  }
  if (last) items += close_run();
  return items;
}

CheckpointLog::Appended CheckpointLog::append() {
  const bool run = announced_.front() != 0;
  announced_.pop();
  return {head_++, run};
}

CheckpointLog::Read CheckpointLog::read() {
  if (reading_.count > 0) {
    position_ = reading_.first;
    reading_.first = reading_.position(1);
    --reading_.count;
    ++counters_.references_read;
    return {position_, false, reading_.step < 0};
  }
  assert(begin_ != end_);
  const std::uint64_t at = lifo_ ? --end_ : begin_++;
  begun_ = true;
  const bool any = lifo_ ? unread_ > 0 : unread_ < runs_.size();
  const std::size_t next = lifo_ ? unread_ - 1 : unread_;
  if (!any || runs_[next].at != at) {
    position_ = at;
    return {at, false, lifo_};
  }
  reading_ = runs_[next].run;
  lifo_ ? --unread_ : ++unread_;
  if (lifo_) reading_ = {reading_.position(reading_.count - 1), reading_.count, -reading_.step};
  ++counters_.runs_read;
  return {at, true, lifo_};
}

CheckpointLog::Unread CheckpointLog::unread() const {
  Unread rest{lifo_ ? end_ - 1 : begin_, end_ - begin_, 0, begun_};
  if (reading_.count > 0) return rest;
  const bool any = lifo_ ? unread_ > 0 : unread_ < runs_.size();
  if (!any) {
    rest.until_run = rest.places;
  } else {
    rest.until_run = lifo_ ? end_ - 1 - runs_[unread_ - 1].at : runs_[unread_].at - begin_;
  }
  return rest;
}

void CheckpointLog::leave(const std::vector<Placed>& runs, std::size_t first, std::size_t last) {
  counters_.runs_left += last - first;
  for (std::size_t i = first; i < last; ++i) counters_.references_left += runs[i].run.count;
}

void CheckpointLog::count(Counters& all) const {
  CheckpointLog rest = *this;
  rest.lifo_ ? rest.leave(runs_, 0, unread_) : rest.leave(runs_, unread_, runs_.size());
  rest.leave(written_, 0, written_.size());
  all.add(rest.counters_);
}

}  // namespace grtx::modules
