#include "grtx/modules/dram/decide/dram_channel.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <ostream>
#include <stdexcept>
#include <utility>

namespace grtx::modules {

namespace {

constexpr std::uint64_t kNoKey = ~std::uint64_t{0};

std::uint64_t least_key(std::uint64_t banks, const std::vector<std::uint64_t>& keys) {
  std::uint64_t least = kNoKey;
  for (; banks != 0; banks &= banks - 1) {
    least = std::min(least, keys[static_cast<std::size_t>(std::countr_zero(banks))]);
  }
  return least;
}

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
      oldest_key_(config.banks),
      hit_key_(config.banks),
      wake_(config.banks),
      completions_(256) {
  if (scheduling_ == nullptr) scheduling_ = make_dram_scheduling(config);
  if (scheduling_ == nullptr && config.scheduling == kFrFcfsCap) overtaken_.resize(config.banks);
  for (unsigned i = config.queue; i > 0; --i) free_.push_back(i - 1);
  if (config.timing.groups_differ()) {
    groups_.resize(config.bank_groups);
    for (std::uint32_t b = 0; b < config.banks; ++b) groups_[mapping_.group(b)].banks |= std::uint64_t{1} << b;
  }
  if (config.timing.refi != 0) refresh_at_ = config.timing.refi;
  plain_ = scheduling_ == nullptr && groups_.empty() && refresh_at_ == kNever;
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

void DramChannel::enqueue(Cycle now, std::uint64_t id, std::uint64_t address, unsigned bytes, bool write) {
  assert(can_accept(bytes) && next_ >= now);
  while (refresh_at_ < now) refresh_all_banks(refresh_at_);  // of a channel without requests
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
  e.activated = e.precharged = false;
  if (bank.newest != kNone) {
    entries_[bank.newest].newer = number;
  } else {
    set_oldest(bank, number);
  }
  bank.newest = number;
  if (bank.open && bank.hit == kNone && bank.row == e.row) set_hit(bank, number);
  busy_banks_ |= std::uint64_t{1} << e.bank;
  first_ages_at_ = std::min(first_ages_at_, bank.ages_at);
  if (scheduling_ == nullptr) reconsider(now, e.bank);
  ++queued_;
  queued_bursts_ += e.remaining;
  ++(write ? counters_.writes : counters_.reads);
  counters_.bytes += bytes;
  next_ = now;
}

// What the bank waits for: a column command for its hit, or a row command for its oldest request. A bank that may not
// yet have it, or whose oldest request ages, is looked at again when its time has come.
void DramChannel::reconsider(Cycle now, std::uint32_t number) {
  const std::uint64_t bit = std::uint64_t{1} << number;
  Bank& bank = banks_[number];
  banks_that(bank.ready) &= ~bit;
  bank.ready = Ready::none;
  if ((timed_ & bit) != 0) unbook(number);
  if (bank.oldest == kNone) return;
  Cycle at = 0;
  Cycle wake = kNever;
  Ready ready = Ready::none;
  if (bank.hit != kNone && bank.hit_first(now)) {
    at = bank.can_column();
    ready = bank.hit_write ? Ready::write : Ready::read;
    if (bank.hit != bank.oldest) wake = bank.ages_at;
  } else {
    at = bank.open ? bank.can_precharge : bank.can_activate;
    ready = bank.open ? Ready::precharge : Ready::activate;
  }
  if (at <= now) {
    bank.ready = ready;
    banks_that(ready) |= bit;
  } else {
    wake = std::min(wake, at);
  }
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

// fr_fcfs_cap (FR-FCFS+Cap of Mutlu and Moscibroda, MICRO 2007): as fr_fcfs, but only so many column commands of a bank
// overtake its oldest request. What is counted is forgotten when that request gets a command.
void DramChannel::count_overtaking(Bank& bank, std::uint32_t number, bool overtakes) {
  overtaken_[number] = overtakes ? overtaken_[number] + 1 : 0;
  bank.capped = overtaken_[number] >= config_.hit_cap;
}

unsigned DramChannel::scheduling_bits_per_bank() const {
  if (scheduling_ != nullptr) return scheduling_->bits_per_bank();
  return overtaken_.empty() ? 0 : static_cast<unsigned>(std::bit_width(config_.hit_cap));
}

// Whether a hit other than `column` is past the age cap and the oldest hit of all.
bool DramChannel::older_hit_has_aged(Cycle now, std::uint32_t column) {
  if (now < first_ages_at_) return false;
  first_ages_at_ = kNever;
  std::uint64_t order = ~std::uint64_t{0};
  std::uint32_t oldest = kNone;
  for (std::uint64_t rest = busy_banks_; rest != 0; rest &= rest - 1) {
    const Bank& bank = banks_[static_cast<std::size_t>(std::countr_zero(rest))];
    first_ages_at_ = std::min(first_ages_at_, bank.ages_at);
    if (bank.hit == kNone || !bank.hit_first(now)) continue;
    if (entries_[bank.hit].order >= order) continue;
    order = entries_[bank.hit].order;
    oldest = bank.hit;
  }
  return oldest != kNone && oldest != column && aged(entries_[oldest], now);
}

// fr_fcfs, first ready, first come (Rixner et al., ISCA 2000), with an age cap: the oldest row hit whose timing allows
// it gets the column command; the oldest request whose bank holds another row, or none, gets the row command. A request
// past the age cap lets nothing overtake it: its bank serves no younger hits, and the data bus waits for it once its
// row is open.
template <bool plain>
void DramChannel::step_fr_fcfs(Cycle now) {
  if ((wake_clocks_ >> now % kWheel & 1) != 0) wake_banks(now);
  std::uint64_t reads = next_read_ <= now ? banks_that(Ready::read) : 0;
  std::uint64_t writes = next_write_ <= now ? banks_that(Ready::write) : 0;
  std::uint64_t activates = next_activate_ <= now ? banks_that(Ready::activate) : 0;
  if constexpr (!plain) {
    for (const Group& group : groups_) {
      if (group.can_read > now) reads &= ~group.banks;
      if (group.can_write > now) writes &= ~group.banks;
      if (group.can_activate > now) activates &= ~group.banks;
    }
  }
  const std::uint64_t columns = reads | writes;
  const std::uint64_t rows = banks_that(Ready::precharge) | activates;
  const std::uint64_t row = least_key(rows, oldest_key_);
  const std::uint64_t column = least_key(columns, hit_key_);
  const bool held_back = column != kNoKey && older_hit_has_aged(now, banks_[column % 64].hit);
  if (row != kNoKey) {
    issue_row(now, banks_[row % 64].oldest);
    reconsider(now, row % 64);
  }
  if (column != kNoKey && !held_back) {
    issue_column(now, banks_[column % 64].hit);
    reconsider(now, column % 64);
  }
  if (busy_banks_ == 0) {
    next_ = kNever;
    return;
  }
  Cycle next = kNever;
  if (wake_clocks_ != 0) {
    next =
        now + 1 + static_cast<Cycle>(std::countr_zero(std::rotr(wake_clocks_, static_cast<int>((now + 1) % kWheel))));
  }
  if (plain || groups_.empty()) {
    if (banks_that(Ready::read) != 0) next = std::min(next, next_read_);
    if (banks_that(Ready::write) != 0) next = std::min(next, next_write_);
    if (banks_that(Ready::activate) != 0) next = std::min(next, next_activate_);
  } else {
    for (const Group& group : groups_) {
      const auto wait = [&](Ready ready, Cycle at) {
        if ((banks_that(ready) & group.banks) != 0) next = std::min(next, at);
      };
      wait(Ready::read, std::max(next_read_, group.can_read));
      wait(Ready::write, std::max(next_write_, group.can_write));
      wait(Ready::activate, std::max(next_activate_, group.can_activate));
    }
  }
  if (banks_that(Ready::precharge) != 0) next = 0;
  if (!plain) next = std::min(next, refresh_at_);
  next_ = std::max(next, now + 1);
}

template void DramChannel::step_fr_fcfs<true>(Cycle now);
template void DramChannel::step_fr_fcfs<false>(Cycle now);

Cycle DramChannel::column_at(std::uint32_t number) const {
  const Bank& bank = banks_[number];
  const Cycle at = std::max(bank.can_column(), bank.hit_write ? next_write_ : next_read_);
  if (groups_.empty()) return at;
  const Group& group = groups_[mapping_.group(number)];
  return std::max(at, bank.hit_write ? group.can_write : group.can_read);
}

Cycle DramChannel::row_at(std::uint32_t number) const {
  const Bank& bank = banks_[number];
  if (bank.open) return bank.can_precharge;
  const Cycle at = std::max(bank.can_activate, next_activate_);
  return groups_.empty() ? at : std::max(at, groups_[mapping_.group(number)].can_activate);
}

// No command but these is issued from the clock in which the refresh is due until it is over: all open rows are closed
// with one precharge, as soon as each may be; the refresh follows as soon as each bank could be activated.
void DramChannel::refresh_all_banks(Cycle now) {
  const DramTiming& t = config_.timing;
  Cycle precharge = now;
  for (const Bank& bank : banks_) {
    if (bank.open) precharge = std::max(precharge, bank.can_precharge);
  }
  Cycle start = now;
  for (Bank& bank : banks_) {
    if (bank.open) {
      ++counters_.precharges;
      bank.can_activate = std::max(bank.can_activate, precharge + t.rp);
    }
    start = std::max(start, bank.can_activate);
  }
  for (Bank& bank : banks_) {
    bank.open = false;
    bank.hit = kNone;
    bank.can_activate = start + std::max(t.rfc, 1u);  // the refresh takes the clock of its command
  }
  ++counters_.refreshes;
  refresh_at_ += t.refi;
  if (scheduling_ != nullptr) return;
  for (std::uint64_t rest = busy_banks_; rest != 0; rest &= rest - 1) {
    reconsider(now, static_cast<std::uint32_t>(std::countr_zero(rest)));
  }
}

void DramChannel::step_as_told(Cycle now) {
  Cycle next = refresh_at_;
  bool ready = false;
  shown_.clear();
  for (std::uint64_t rest = busy_banks_; rest != 0; rest &= rest - 1) {
    const auto number = static_cast<std::uint32_t>(std::countr_zero(rest));
    const Bank& bank = banks_[number];
    const Entry& oldest = entries_[bank.oldest];
    DramBankQueue queue;
    queue.bank = number;
    queue.oldest = oldest.order;
    queue.oldest_since = oldest.enqueued;
    if (bank.hit != kNone) {
      const Cycle at = column_at(number);
      queue.has_hit = true;
      queue.hit = entries_[bank.hit].order;
      queue.hit_since = entries_[bank.hit].enqueued;
      queue.hit_write = bank.hit_write;
      queue.column_ready = at <= now;
      ready |= queue.column_ready;
      next = std::min(next, at);
    }
    if (bank.hit != bank.oldest) {
      const Cycle at = row_at(number);
      queue.row_ready = at <= now;
      ready |= queue.row_ready;
      next = std::min(next, at);
    }
    shown_.push_back(queue);
  }
  if (ready) {
    const DramChoice choice = scheduling_->choose(now, shown_);
    const bool row = choice.row != DramChoice::kNone, column = choice.column != DramChoice::kNone;
    if ((row && !shown_.at(choice.row).row_ready) || (column && !shown_.at(choice.column).column_ready) ||
        (row && choice.row == choice.column)) {
      throw std::logic_error("the DRAM scheduling " + config_.scheduling + " chose a command that is not ready");
    }
    if (row) issue_row(now, banks_[shown_[choice.row].bank].oldest);
    if (column) issue_column(now, banks_[shown_[choice.column].bank].hit);
  }
  next_ = busy_banks_ == 0 ? kNever : std::max(next, now + 1);
}

void DramChannel::issue_column(Cycle now, std::uint32_t number) {
  const DramTiming& t = config_.timing;
  Entry& e = entries_[number];
  Bank& bank = banks_[e.bank];
  if (!overtaken_.empty()) count_overtaking(bank, e.bank, bank.hit != bank.oldest);
  next_read_ = std::max(next_read_, now + (e.write ? t.write_to_read() : t.ccd));
  next_write_ = std::max(next_write_, now + (e.write ? t.ccd : t.read_to_write()));
  bank.can_precharge = std::max(bank.can_precharge, now + (e.write ? t.write_to_precharge() : t.rtp));
  if (!groups_.empty()) {
    Group& group = groups_[mapping_.group(e.bank)];
    group.can_read = std::max(group.can_read, now + (e.write ? t.write_to_read_of_group() : t.ccd_of_group()));
    if (e.write) group.can_write = std::max(group.can_write, now + t.ccd_of_group());
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
  if (!overtaken_.empty()) count_overtaking(bank, e.bank, false);
  if (bank.open) {
    bank.open = false;
    bank.hit = kNone;
    bank.can_activate = std::max(bank.can_activate, now + t.rp);
    e.precharged = true;
    ++counters_.precharges;
    return;
  }
  bank.open = true;
  bank.row = e.row;
  bank.can_activate = now + t.rc;
  bank.can_read = now + t.rcd;
  bank.can_write = now + t.activate_to_write();
  bank.can_precharge = now + t.ras;
  next_activate_ = now + t.rrd;
  if (!groups_.empty()) groups_[mapping_.group(e.bank)].can_activate = now + t.rrd_of_group();
  activated_[counters_.activates % 4] = now;
  e.activated = true;
  ++counters_.activates;
  if (t.faw != 0 && counters_.activates >= 4) {
    next_activate_ = std::max(next_activate_, activated_[counters_.activates % 4] + t.faw);
  }
  find_hit(bank, bank.oldest);
}

// The oldest entry of the open row, from this one on.
void DramChannel::find_hit(Bank& bank, std::uint32_t from) {
  while (from != kNone && entries_[from].row != bank.row) from = entries_[from].newer;
  set_hit(bank, from);
}

void DramChannel::set_hit(Bank& bank, std::uint32_t entry) {
  bank.hit = entry;
  if (entry == kNone) return;
  const Entry& e = entries_[entry];
  hit_key_[e.bank] = key(e);
  bank.hit_write = e.write;
}

void DramChannel::set_oldest(Bank& bank, std::uint32_t entry) {
  bank.oldest = entry;
  if (entry == kNone) return;
  const Entry& e = entries_[entry];
  oldest_key_[e.bank] = key(e);
  bank.ages_at = e.enqueued + config_.age_cap + 1;
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
  if (bank.oldest == kNone) busy_banks_ &= ~(std::uint64_t{1} << e.bank);
  if (bank.hit == number) find_hit(bank, e.newer);  // it was the oldest of its row
  free_.push_back(number);
  --queued_;
}

Cycle DramChannel::run_until_room(unsigned bytes) {
  Cycle clock = next_;
  while (!can_accept(bytes)) {
    clock = next_;
    assert(clock != kNever);
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
