// SPDX-License-Identifier: Apache-2.0
// Which command a plain DRAM channel issues in a clock: docs/model/dram.md. Looks at all bursts in every clock.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "grtx/modules/dram/decide/dram_config.h"
#include "rtl_tlm/plain/channel.h"

namespace grtx::sim::plain {

class DramCommands {
 public:
  using Config = modules::DramChannelConfig;
  struct Burst {
    std::uint64_t request;
    bool write;
    std::uint64_t bank, row;
    Cycle arrival;
  };
  /// What was issued in a clock.
  struct Issued {
    std::optional<Burst> row;  ///< whose bank was activated, or precharged
    bool precharge = false;
    std::optional<Burst> column;
    Cycle done = 0;  ///< its data are there
  };

  explicit DramCommands(const Config& config) : config_(config), banks_(config.banks), groups_(config.bank_groups) {}

  std::size_t queued() const { return bursts_.size(); }
  /// Refreshes, and the precharges for them, that were due before the last column command.
  std::uint64_t refreshes() const { return refreshes_; }
  std::uint64_t refresh_precharges() const { return refresh_precharges_; }
  bool aged(const Burst& burst, Cycle now) const { return now > burst.arrival + config_.age_cap; }

  /// address: within the channel.
  void enqueue(Cycle now, std::uint64_t request, std::uint64_t address, bool write) {
    const std::uint64_t groups = config_.bank_groups, of_a_group = config_.banks / groups;
    std::uint64_t group = 0;
    if (groups > 1) {  // consecutive blocks go to the groups in turn
      const std::uint64_t block = address / config_.group_bytes;
      group = block % groups;
      address = block / groups * config_.group_bytes + address % config_.group_bytes;
    }
    const std::uint64_t row_number = address / config_.row_bytes, row = row_number / of_a_group;
    std::uint64_t bank = row_number % of_a_group * groups + group;
    if (config_.bank_xor) bank ^= row % config_.banks;
    bursts_.push_back({request, write, bank, row, now});
  }

  Issued step(Cycle now) {
    Issued issued;
    if (refreshes_now(now)) return issued;
    const std::map<std::uint64_t, View> banks = views(now);
    std::size_t column = kNone, row = kNone, first_hit = kNone;
    for (const auto& [number, view] : banks) {
      if (config_.scheduling == "fcfs") {
        if (view.oldest == 0 && view.hit == 0 && view.column_ready) column = 0;
        if (view.row_ready) row = std::min(row, view.oldest);
      } else if (view.hit_first) {
        first_hit = std::min(first_hit, view.hit);
        if (view.column_ready) column = std::min(column, view.hit);
      } else if (view.row_ready) {
        row = std::min(row, view.oldest);
      }
    }
    // The data bus waits for an aged hit.
    if (first_hit != kNone && first_hit != column && aged(bursts_[first_hit], now)) column = kNone;
    if (row != kNone) {
      issued.row = bursts_[row];
      issued.precharge = row_command(now, bursts_[row]);
    }
    if (column != kNone) {
      Bank& bank = banks_[bursts_[column].bank];
      bank.overtaken = column == banks.at(bursts_[column].bank).oldest ? 0 : bank.overtaken + 1;
      issued.column = bursts_[column];
      issued.done = column_command(now, bursts_[column]);
      bursts_.erase(bursts_.begin() + static_cast<std::ptrdiff_t>(column));
    }
    return issued;
  }

 private:
  static constexpr std::size_t kNone = ~std::size_t{0};

  struct Bank {
    std::optional<std::uint64_t> row;
    Cycle activate_from = 0, precharge_from = 0, read_from = 0, write_from = 0;  ///< earliest next command
    unsigned overtaken = 0;  ///< column commands for hits younger than the oldest request, in a row
  };
  struct Group {
    Cycle activate_from = 0, read_from = 0, write_from = 0;
  };
  Group& group_of(std::uint64_t bank) { return groups_[bank % config_.bank_groups]; }
  const Group& group_of(std::uint64_t bank) const { return groups_[bank % config_.bank_groups]; }

  /// What the scheduler sees of a bank with requests. Bursts are named by their places in the queue.
  struct View {
    std::size_t oldest;
    std::size_t hit = kNone;  ///< the oldest burst for the open row
    bool column_ready = false, row_ready = false;
    bool hit_first = false;  ///< the bank serves its hit before its oldest burst
  };
  std::map<std::uint64_t, View> views(Cycle now) const {
    std::map<std::uint64_t, View> all;
    for (std::size_t i = 0; i < bursts_.size(); ++i) {
      const Burst& burst = bursts_[i];
      View& view = all.try_emplace(burst.bank, View{i}).first->second;
      if (view.hit == kNone && banks_[burst.bank].row == burst.row) view.hit = i;
    }
    for (auto& [number, view] : all) {
      const Bank& bank = banks_[number];
      const Group& group = group_of(number);
      if (view.hit != kNone) {
        view.column_ready = now >= (bursts_[view.hit].write ? std::max({write_from_, bank.write_from, group.write_from})
                                                            : std::max({read_from_, bank.read_from, group.read_from}));
      }
      const bool lacks_row = view.hit != view.oldest;
      const Cycle row_from =
          bank.row ? bank.precharge_from : std::max({bank.activate_from, activate_from_, group.activate_from});
      view.row_ready = lacks_row && now >= row_from;
      const bool capped = config_.scheduling == "fr_fcfs_cap" && bank.overtaken >= config_.hit_cap;
      view.hit_first = view.hit != kNone && (!lacks_row || (!aged(bursts_[view.oldest], now) && !capped));
    }
    return all;
  }
  /// When the data are there.
  Cycle column_command(Cycle now, const Burst& burst) {
    const modules::DramTiming& t = config_.timing;
    Bank& bank = banks_[burst.bank];
    Group& group = group_of(burst.bank);
    const Cycle ccd_l = std::max(t.ccd, t.ccd_l), cdlr_l = std::max(t.cdlr, t.cdlr_l);
    const Cycle turn = t.cl + t.ccd + t.turn;
    const Cycle write_behind_read = turn > t.wl ? turn - t.wl : 1;
    read_from_ = std::max(read_from_, now + (burst.write ? t.wl + t.ccd + t.cdlr : t.ccd));
    write_from_ = std::max(write_from_, now + (burst.write ? t.ccd : write_behind_read));
    group.read_from = std::max(group.read_from, now + (burst.write ? t.wl + t.ccd + cdlr_l : ccd_l));
    if (burst.write) group.write_from = std::max(group.write_from, now + ccd_l);
    bank.precharge_from = std::max<Cycle>(bank.precharge_from, now + (burst.write ? t.wl + t.ccd + t.wr : t.rtp));
    refreshes_ += due_refreshes_;
    refresh_precharges_ += due_precharges_;
    due_refreshes_ = due_precharges_ = 0;
    return now + (burst.write ? t.wl : t.cl) + t.ccd;
  }
  /// Whether it closed a row.
  bool row_command(Cycle now, const Burst& burst) {
    const modules::DramTiming& t = config_.timing;
    Bank& bank = banks_[burst.bank];
    bank.overtaken = 0;
    if (bank.row) {
      bank.row.reset();
      bank.activate_from = std::max<Cycle>(bank.activate_from, now + t.rp);
      return true;
    }
    bank.row = burst.row;
    bank.read_from = now + t.rcd;
    bank.write_from = now + (t.rcd_wr != 0 ? t.rcd_wr : t.rcd);
    bank.precharge_from = now + t.ras;
    bank.activate_from = now + t.rc;
    activate_from_ = now + t.rrd;
    group_of(burst.bank).activate_from = now + std::max(t.rrd, t.rrd_l);
    activates_.push_back(now);
    if (t.faw != 0 && activates_.size() >= 4) {
      activate_from_ = std::max(activate_from_, activates_[activates_.size() - 4] + t.faw);
    }
    return false;
  }
  /// Whether this clock is a refresh's: all rows are closed as soon as each may be, then all banks refreshed.
  bool refreshes_now(Cycle now) {
    const modules::DramTiming& t = config_.timing;
    if (t.refi != 0 && now != 0 && now % t.refi == 0) due_ = true;
    if (!due_) return false;
    const auto any = [this](auto&& holds) { return std::any_of(banks_.begin(), banks_.end(), holds); };
    if (any([](const Bank& b) { return b.row.has_value(); })) {
      if (any([&](const Bank& b) { return b.row && b.precharge_from > now; })) return true;
      for (Bank& b : banks_) {
        if (!b.row) continue;
        b.activate_from = std::max<Cycle>(b.activate_from, now + t.rp);
        b.row.reset();
        ++due_precharges_;
      }
    }
    if (any([&](const Bank& b) { return b.activate_from > now; })) return true;
    for (Bank& b : banks_) b.activate_from = now + t.rfc;
    ++due_refreshes_;
    due_ = false;
    return true;
  }

  Config config_;
  std::vector<Bank> banks_;
  std::vector<Group> groups_;
  std::deque<Burst> bursts_;  ///< oldest first
  std::vector<Cycle> activates_;
  Cycle read_from_ = 0, write_from_ = 0, activate_from_ = 0;  ///< of the whole channel
  bool due_ = false;                                          ///< a refresh
  std::uint64_t refreshes_ = 0, refresh_precharges_ = 0, due_refreshes_ = 0, due_precharges_ = 0;
};

}  // namespace grtx::sim::plain
