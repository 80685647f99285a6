// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/dram/decide/dram_channel.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <ostream>
#include <string>
#include <utility>

#include "grtx/modules/kernel/wrong_answer.h"

namespace grtx::modules {
namespace {

/// Clocks in which a policy must have made room in a full queue: four of the longest refresh intervals.
constexpr Cycle kLongestWait = Cycle{1} << 22;

}  // namespace

const DramChannelConfig& DramChannel::checked(const DramChannelConfig& config) {
  require_allowed("dram", config);
  require_allowed("dram.timing", config.timing);
  return config;
}

DramChannel::DramChannel(const DramChannelConfig& config) : DramChannel(config, nullptr) {}

DramChannel::DramChannel(const DramChannelConfig& config, std::unique_ptr<DramScheduling> scheduling)
    : config_(config),
      scheduling_(std::move(scheduling)),
      mapping_(checked(config)),
      entries_(config.queue),
      banks_(config.banks),
      wake_(config.banks),
      completions_(256) {
  if (scheduling_ == nullptr) scheduling_ = make_dram_scheduling(config);
  queues_.oldest.resize(config.banks);
  queues_.hit.resize(config.banks);
  for (unsigned i = config.queue; i > 0; --i) free_.push_back(i - 1);
  if (config.timing.groups_differ()) {
    groups_.resize(config.bank_groups);
    for (std::uint32_t b = 0; b < config.banks; ++b) groups_[mapping_.group(b)].banks |= std::uint64_t{1} << b;
  }
  if (config.timing.refi != 0) refresh_at_ = config.timing.refi;
}

void DramChannel::restart(bool keep_rows) {
  assert(idle());
  const std::vector<Bank> before = std::move(banks_);
  *this = DramChannel(DramChannelConfig(config_));
  if (!keep_rows) return;
  for (std::size_t i = 0; i < banks_.size(); ++i) {
    banks_[i].open = before[i].open;
    banks_[i].row = before[i].row;
  }
}

void DramChannel::enqueue(Cycle now, std::uint64_t id, std::uint64_t address, unsigned bytes, bool write,
                          RequestOrigin origin) {
  assert(can_accept(bytes) && next_ >= now);
  while (refresh_at_ < now) refresh_all_banks(refresh_at_);  // refreshes that were skipped while there were no requests
  count_queue(now);
  const std::uint32_t number = free_.back();
  free_.pop_back();
  Entry& e = entries_[number];
  const DramMapping::Place place = mapping_.place(address);
  Bank& bank = banks_[place.bank];
  e.id = id;
  e.row = place.row;
  e.order = next_order_++;
  e.enqueued = now;
  e.newer = kNone;
  e.older = bank.newest;
  e.bank = place.bank;
  e.remaining = bursts(bytes);
  e.write = write;
  e.origin = origin;
  e.activated = e.precharged = false;
  if (bank.newest != kNone) {
    entries_[bank.newest].newer = number;
  } else {
    set_oldest(bank, number);
  }
  bank.newest = number;
  if (bank.open && bank.hit == kNone && bank.row == e.row) set_hit(bank, number);
  queues_.busy |= std::uint64_t{1} << e.bank;
  reconsider(now, e.bank);
  ++queued_;
  queued_bursts_ += e.remaining;
  ++(write ? counters_.writes : counters_.reads);
  counters_.bytes += bytes;
  next_ = now;
}

// Updates which commands the bank wants: a column command for its hit, a row command for its oldest request. If its
// timing does not allow one yet, the bank is reconsidered when it does.
void DramChannel::reconsider(Cycle now, std::uint32_t number) {
  const std::uint64_t bit = std::uint64_t{1} << number;
  const Bank& bank = banks_[number];
  const bool hit = bank.hit != kNone, lacks_row = bank.oldest != kNone && bank.oldest != bank.hit;
  for (std::uint64_t& banks : ready_) banks &= ~bit;
  queues_.hits = hit ? queues_.hits | bit : queues_.hits & ~bit;
  queues_.overtaking = hit && lacks_row ? queues_.overtaking | bit : queues_.overtaking & ~bit;
  if ((timed_ & bit) != 0) unbook(number);
  Cycle wake = kNever;
  const auto await = [&](Command command) {
    if (bank.from[command] <= now) {
      ready_[command] |= bit;
    } else {
      wake = std::min(wake, bank.from[command]);
    }
  };
  if (hit) await(queues_.hit[number].write ? kWrite : kRead);
  if (lacks_row) await(bank.open ? kPrecharge : kActivate);
  if (wake != kNever) book(std::min(wake, now + kWheel - 1), number);
}

void DramChannel::book(Cycle clock, std::uint32_t bank) {
  timed_ |= std::uint64_t{1} << bank;
  wake_[bank] = static_cast<std::uint8_t>(clock % kWheel);
  wakes_[clock % kWheel] |= std::uint64_t{1} << bank;
  wake_clocks_ |= std::uint64_t{1} << clock % kWheel;
}

void DramChannel::unbook(std::uint32_t bank) {
  timed_ &= ~(std::uint64_t{1} << bank);
  std::uint64_t& banks = wakes_[wake_[bank]];
  banks &= ~(std::uint64_t{1} << bank);
  if (banks == 0) wake_clocks_ &= ~(std::uint64_t{1} << wake_[bank]);
}

void DramChannel::wake_banks(Cycle now) {
  for (std::uint64_t rest = wakes_[now % kWheel]; rest != 0; rest &= rest - 1) {
    reconsider(now, static_cast<std::uint32_t>(std::countr_zero(rest)));
  }
}

// Banks that want this command and for which all timing constraints allow it.
std::uint64_t DramChannel::allowed(Command command, Cycle now) const {
  if (from_[command] > now) return 0;
  std::uint64_t banks = ready_[command];
  for (const Group& group : groups_) {
    if (group.from[command] > now) banks &= ~group.banks;
  }
  return banks;
}

void DramChannel::step(Cycle now) {
  if (now >= refresh_at_ && queues_.busy != 0) refresh_all_banks(now);
  if ((wake_clocks_ >> now % kWheel & 1) != 0) wake_banks(now);
  queues_.columns = allowed(kRead, now) | allowed(kWrite, now);
  queues_.rows = allowed(kPrecharge, now) | allowed(kActivate, now);
  DramChoice choice;
  if ((queues_.columns | queues_.rows) != 0) {
    choice = scheduling_->choose(now, queues_);
    obey(now, choice);
  }
  next_ = next_step(now, choice);
}

void DramChannel::obey(Cycle now, const DramChoice& choice) {
  const auto is_one_of = [](unsigned bank, std::uint64_t banks) { return bank < 64 && (banks >> bank & 1) != 0; };
  const bool row = choice.row != DramQueues::kNone, column = choice.column != DramQueues::kNone;
  if ((row && !is_one_of(choice.row, queues_.rows)) || (column && !is_one_of(choice.column, queues_.columns)) ||
      (row && choice.row == choice.column)) {
    const auto bank = [](unsigned chosen) { return chosen == DramQueues::kNone ? "none" : std::to_string(chosen); };
    throw WrongAnswer("the DRAM scheduling " + config_.scheduling + " chose a command that is not ready: row of bank " +
                      bank(choice.row) + ", column of bank " + bank(choice.column));
  }
  if (row) {
    issue_row(now, banks_[choice.row].oldest);
    reconsider(now, choice.row);
  }
  if (column) {
    issue_column(now, banks_[choice.column].hit);
    reconsider(now, choice.column);
  }
}

// The next clock in which a command can issue, other than those that the policy has declined.
Cycle DramChannel::next_step(Cycle now, const DramChoice& choice) const {
  if (queues_.busy == 0) return kNever;
  std::uint64_t moved = 0;
  for (const unsigned bank : {choice.row, choice.column}) {
    if (bank != DramQueues::kNone) moved |= std::uint64_t{1} << bank;
  }
  const std::uint64_t columns = choice.declined_columns & ~moved, rows = choice.declined_rows & ~moved;
  Cycle next = std::min(refresh_at_, (columns | rows) != 0 ? choice.again : kNever);
  if (wake_clocks_ != 0) {
    const std::uint64_t from_next_on = std::rotr(wake_clocks_, static_cast<int>((now + 1) % kWheel));
    next = std::min(next, now + 1 + static_cast<Cycle>(std::countr_zero(from_next_on)));
  }
  next = std::min({next, next_for(kRead, columns), next_for(kWrite, columns), next_for(kPrecharge, rows),
                   next_for(kActivate, rows)});
  return std::max(next, now + 1);
}

Cycle DramChannel::next_for(Command command, std::uint64_t declined) const {
  const std::uint64_t banks = ready_[command] & ~declined;
  if (banks == 0) return kNever;
  if (groups_.empty()) return from_[command];
  Cycle next = kNever;
  for (const Group& group : groups_) {
    if ((banks & group.banks) != 0) next = std::min(next, std::max(from_[command], group.from[command]));
  }
  return next;
}

// From the clock in which the refresh is due until it ends no other command is issued. One precharge closes all open
// rows as soon as every bank allows it; the refresh follows as soon as every bank could be activated.
void DramChannel::refresh_all_banks(Cycle now) {
  const DramTiming& t = config_.timing;
  Cycle precharge = now;
  for (const Bank& bank : banks_) {
    if (bank.open) precharge = std::max(precharge, bank.from[kPrecharge]);
  }
  Cycle start = now;
  for (Bank& bank : banks_) {
    if (bank.open) {
      ++counters_.precharges;
      bank.from[kActivate] = std::max(bank.from[kActivate], precharge + t.rp);
    }
    start = std::max(start, bank.from[kActivate]);
  }
  for (Bank& bank : banks_) {
    bank.open = false;
    bank.hit = kNone;
    bank.from[kActivate] = start + std::max(t.rfc, 1u);  // the refresh takes the clock of its command
  }
  ++counters_.refreshes;
  refresh_at_ += t.refi;
  for (std::uint64_t rest = queues_.busy; rest != 0; rest &= rest - 1) {
    reconsider(now, static_cast<std::uint32_t>(std::countr_zero(rest)));
  }
}

void DramChannel::issue_column(Cycle now, std::uint32_t number) {
  const DramTiming& t = config_.timing;
  Entry& e = entries_[number];
  Bank& bank = banks_[e.bank];
  const auto not_before = [](Cycle& from, Cycle clock) { from = std::max(from, clock); };
  not_before(from_[kRead], now + (e.write ? t.write_to_read() : t.ccd));
  not_before(from_[kWrite], now + (e.write ? t.ccd : t.read_to_write()));
  not_before(bank.from[kPrecharge], now + (e.write ? t.write_to_precharge() : t.rtp));
  if (!groups_.empty()) {
    Group& group = groups_[mapping_.group(e.bank)];
    not_before(group.from[kRead], now + (e.write ? t.write_to_read_of_group() : t.ccd_of_group()));
    if (e.write) not_before(group.from[kWrite], now + t.ccd_of_group());
  }
  count_queue(now);
  ++counters_.bursts;
  --queued_bursts_;
  if (--e.remaining > 0) return;
  const Cycle done = now + (e.write ? t.wl : t.cl) + t.ccd;
  ++(e.precharged ? counters_.row_conflicts : e.activated ? counters_.row_misses : counters_.row_hits);
  if (aged(e, now)) ++counters_.aged;
  counters_.latency_clocks += done - e.enqueued;
  completions_.push({e.id, done});
  remove(number);
}

void DramChannel::issue_row(Cycle now, std::uint32_t number) {
  const DramTiming& t = config_.timing;
  Entry& e = entries_[number];
  Bank& bank = banks_[e.bank];
  if (bank.open) {
    bank.open = false;
    bank.hit = kNone;
    bank.from[kActivate] = std::max(bank.from[kActivate], now + t.rp);
    e.precharged = true;
    ++counters_.precharges;
    return;
  }
  bank.open = true;
  bank.row = e.row;
  bank.from = {now + t.rcd, now + t.activate_to_write(), now + t.ras, now + t.rc};  // in the order of Command
  from_[kActivate] = now + t.rrd;
  if (!groups_.empty()) groups_[mapping_.group(e.bank)].from[kActivate] = now + t.rrd_of_group();
  activated_[counters_.activates % 4] = now;
  e.activated = true;
  ++counters_.activates;
  if (t.faw != 0 && counters_.activates >= 4) {
    from_[kActivate] = std::max(from_[kActivate], activated_[counters_.activates % 4] + t.faw);
  }
  find_hit(bank, bank.oldest);
}

// Sets the bank's hit: the first entry for the open row, searching from `from` towards newer entries.
void DramChannel::find_hit(Bank& bank, std::uint32_t from) {
  while (from != kNone && entries_[from].row != bank.row) from = entries_[from].newer;
  set_hit(bank, from);
}

void DramChannel::set_hit(Bank& bank, std::uint32_t entry) {
  bank.hit = entry;
  if (entry != kNone) queues_.hit[entries_[entry].bank] = shown(entries_[entry]);
}

void DramChannel::set_oldest(Bank& bank, std::uint32_t entry) {
  bank.oldest = entry;
  if (entry != kNone) queues_.oldest[entries_[entry].bank] = shown(entries_[entry]);
}

void DramChannel::remove(std::uint32_t number) {
  const Entry& e = entries_[number];
  Bank& bank = banks_[e.bank];
  if (e.older != kNone) {
    entries_[e.older].newer = e.newer;
  } else {
    set_oldest(bank, e.newer);
  }
  (e.newer != kNone ? entries_[e.newer].older : bank.newest) = e.older;
  if (bank.oldest == kNone) queues_.busy &= ~(std::uint64_t{1} << e.bank);
  if (bank.hit == number) find_hit(bank, e.newer);  // it was the oldest for the open row
  free_.push_back(number);
  --queued_;
}

Cycle DramChannel::run_until_room(unsigned bytes) {
  const Cycle begin = next_;
  Cycle clock = next_;
  while (!can_accept(bytes)) {
    clock = next_;
    if (clock == kNever || clock - begin > kLongestWait) {
      throw WrongAnswer("the DRAM scheduling " + config_.scheduling +
                        " declines every command of a full queue for ever");
    }
    step(clock);
  }
  return clock;
}

Cycle DramChannel::completion_bound() const {
  if (queued_ == 0) return kNever;
  return next_ + std::min(config_.timing.cl, config_.timing.wl) + config_.timing.ccd;
}

void DramChannel::count_queue(Cycle now) {
  counters_.queue_clocks += queued_bursts_ * (now - queue_counted_);
  queue_counted_ = now;
}

void DramChannel::dump_state(std::ostream& out) const {
  out << "  queue " << queued_bursts_ << '/' << config_.queue << " bursts, completions " << completions_.size();
  if (next_ != kNever) out << ", next command at clock " << next_;
  out << '\n';
  for (std::size_t b = 0; b < banks_.size(); ++b) {
    const Bank& bank = banks_[b];
    for (std::uint32_t i = bank.oldest; i != kNone; i = entries_[i].newer) {
      const Entry& e = entries_[i];
      out << "    bank " << b << (bank.open ? " row " + std::to_string(bank.row) : std::string(" closed")) << ": "
          << (e.write ? "write" : "read") << " row " << e.row << " since clock " << e.enqueued << '\n';
    }
  }
}

}  // namespace grtx::modules
