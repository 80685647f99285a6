// Plain DRAM channel with its side of the sockets: docs/model/dram.md, and docs/model/tlm.md for the phases.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "grtx/modules/dram/dram.h"
#include "rtl_tlm/plain/address_map.h"
#include "rtl_tlm/plain/dram_socket.h"
#include "rtl_tlm/plain/statistics.h"

namespace grtx::sim::plain {

class DramChannel {
 public:
  using Config = modules::Dram::Config;
  /// sockets: of all slices.
  DramChannel(const Config& config, const SliceMap& map, Clock memory, Clock core, unsigned channel,
              std::deque<DramSocket>& sockets)
      : config_(config),
        map_(map),
        memory_(memory),
        core_(core),
        slices_(map.sharers(channel)),
        sockets_(sockets),
        banks_(config.channel.banks) {}

  void tick(Cycle now) {
    take_requests(now);
    if (!config_.perfect) issue_commands(now);
    queue_clocks_ += bursts_.size();
    for (const unsigned slice : slices_) begin_response(now, slice);
  }
  bool idle() const {
    const auto quiet = [this](unsigned slice) { return !sockets_[slice].request && sockets_[slice].responses.empty(); };
    return bursts_.empty() && done_.empty() && std::all_of(slices_.begin(), slices_.end(), quiet);
  }
  std::uint64_t bytes() const { return bytes_; }
  void report(Statistics& s) const {
    s.add("gpu.dram.reads", reads_);
    s.add("gpu.dram.writes", writes_);
    s.add("gpu.dram.bytes", bytes_);
    s.add("gpu.dram.responses", responses_);
    s.add("gpu.dram.row_hits", row_hits_);
    s.add("gpu.dram.row_misses", row_misses_);
    s.add("gpu.dram.row_conflicts", row_conflicts_);
    s.add("gpu.dram.activates", activates_);
    s.add("gpu.dram.precharges", precharges_);
    s.add("gpu.dram.bursts", columns_);
    s.add("gpu.dram.aged", aged_);
    s.add("gpu.dram.queue_clocks", queue_clocks_);
    s.add("gpu.dram.queue_full_clocks", queue_full_);
    s.add("gpu.dram.access_latency.count", latency_.count);
    s.add("gpu.dram.access_latency.sum", latency_.sum);
  }

 private:
  static constexpr std::size_t kNone = ~std::size_t{0};

  struct Burst {
    std::uint64_t request;
    Access access;
    unsigned bank;
    std::uint64_t row;
    Cycle arrival;
  };
  /// What a request still waits for, and which commands it needed.
  struct Parts {
    std::uint64_t left;
    bool activated, precharged;
  };
  struct Bank {
    std::optional<std::uint64_t> row;
    Cycle activate_from = 0, precharge_from = 0, column_from = 0;  ///< earliest next command
    unsigned overtaken = 0;  ///< column commands for hits younger than the oldest request, in a row
  };

  bool asks(Cycle now, unsigned slice) const {
    return sockets_[slice].request && memory_.first_after(sockets_[slice].request->first) <= now;
  }
  Access end_request(Cycle now, unsigned slice) {
    DramSocket& socket = sockets_[slice];
    const Access access = socket.request->second;
    socket.request.reset();
    socket.request_ended = memory_.edge(now);
    ++(access.write ? writes_ : reads_);
    bytes_ += kSector;
    return access;
  }
  void take_requests(Cycle now) {
    if (config_.perfect) {
      for (const unsigned slice : slices_) {
        if (!asks(now, slice)) continue;
        const Access access = end_request(now, slice);
        latency_.add(0);
        done_.emplace(std::pair{now + config_.fixed_latency, order_++}, access);
      }
      return;
    }
    if (!refused_) {  // the first that asks, from the one whose turn it is
      for (std::size_t i = 0; i < slices_.size() && !asks(now, slices_[turn_]); ++i)
        turn_ = (turn_ + 1) % slices_.size();
      if (!asks(now, slices_[turn_])) return;
    }
    const std::uint64_t bursts = (kSector + config_.channel.burst_bytes - 1) / config_.channel.burst_bytes;
    refused_ = bursts_.size() + bursts > config_.channel.queue;
    if (refused_) {
      ++queue_full_;
      return;
    }
    const Access access = end_request(now, slices_[turn_]);
    turn_ = (turn_ + 1) % slices_.size();
    parts_[order_] = {bursts, false, false};
    const std::uint64_t row_number = map_.in_channel(access.address) / config_.channel.row_bytes;
    const std::uint64_t row = row_number / config_.channel.banks;
    std::uint64_t bank = row_number % config_.channel.banks;
    if (config_.channel.bank_xor) bank ^= row % config_.channel.banks;
    for (std::uint64_t b = 0; b < bursts; ++b)
      bursts_.push_back({order_, access, static_cast<unsigned>(bank), row, now});
    ++order_;
  }

  /// What the scheduler sees of a bank with requests. Bursts are named by their places in the queue.
  struct View {
    std::size_t oldest;
    std::size_t hit = kNone;  ///< the oldest burst for the open row
    bool column_ready = false, row_ready = false;
    bool hit_first = false;  ///< the bank serves its hit before its oldest burst
  };
  bool aged(const Burst& burst, Cycle now) const { return now > burst.arrival + config_.channel.age_cap; }
  std::map<unsigned, View> views(Cycle now) const {
    std::map<unsigned, View> all;
    for (std::size_t i = 0; i < bursts_.size(); ++i) {
      const Burst& burst = bursts_[i];
      View& view = all.try_emplace(burst.bank, View{i}).first->second;
      if (view.hit == kNone && banks_[burst.bank].row == burst.row) view.hit = i;
    }
    for (auto& [number, view] : all) {
      const Bank& bank = banks_[number];
      if (view.hit != kNone) {
        const Cycle bus = bursts_[view.hit].access.write ? write_from_ : read_from_;
        view.column_ready = now >= bus && now >= bank.column_from;
      }
      const bool lacks_row = view.hit != view.oldest;
      view.row_ready =
          lacks_row && (bank.row ? now >= bank.precharge_from : now >= bank.activate_from && now >= activate_from_);
      const bool capped = config_.channel.scheduling == "fr_fcfs_cap" && bank.overtaken >= config_.channel.hit_cap;
      view.hit_first = view.hit != kNone && (!lacks_row || (!aged(bursts_[view.oldest], now) && !capped));
    }
    return all;
  }
  void issue_commands(Cycle now) {
    const std::map<unsigned, View> banks = views(now);
    std::size_t column = kNone, row = kNone, first_hit = kNone;
    for (const auto& [number, view] : banks) {
      if (config_.channel.scheduling == "fcfs") {
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
    if (row != kNone) row_command(now, bursts_[row]);
    if (column != kNone) {
      Bank& bank = banks_[bursts_[column].bank];
      bank.overtaken = column == banks.at(bursts_[column].bank).oldest ? 0 : bank.overtaken + 1;
      column_command(now, bursts_[column], bank);
      bursts_.erase(bursts_.begin() + static_cast<std::ptrdiff_t>(column));
    }
  }
  void column_command(Cycle now, const Burst& burst, Bank& bank) {
    const auto& t = config_.channel.timing;
    ++columns_;
    Cycle done;
    if (burst.access.write) {
      write_from_ = now + t.ccd;
      read_from_ = now + t.wl + t.ccd + t.cdlr;
      bank.precharge_from = std::max<Cycle>(bank.precharge_from, now + t.wl + t.ccd + t.wr);
      done = now + t.wl + t.ccd;
    } else {
      read_from_ = now + t.ccd;
      const Cycle turn = t.cl + t.ccd + t.turn;
      write_from_ = now + (turn > t.wl ? turn - t.wl : 0);
      bank.precharge_from = std::max<Cycle>(bank.precharge_from, now + t.rtp);
      done = now + t.cl + t.ccd;
    }
    Parts& parts = parts_.at(burst.request);
    if (--parts.left == 0) {
      ++(parts.precharged ? row_conflicts_ : parts.activated ? row_misses_ : row_hits_);
      parts_.erase(burst.request);
      latency_.add(done - burst.arrival);
      aged_ += aged(burst, now) ? 1 : 0;
      done_.emplace(std::pair{done + config_.fixed_latency, order_++}, burst.access);
    }
  }
  void row_command(Cycle now, const Burst& burst) {
    const auto& t = config_.channel.timing;
    Bank& bank = banks_[burst.bank];
    bank.overtaken = 0;
    if (bank.row) {
      bank.row.reset();
      bank.activate_from = std::max<Cycle>(bank.activate_from, now + t.rp);
      parts_.at(burst.request).precharged = true;
      ++precharges_;
      return;
    }
    bank.row = burst.row;
    bank.column_from = now + t.rcd;
    bank.precharge_from = now + t.ras;
    bank.activate_from = now + t.rc;
    activate_from_ = now + t.rrd;
    parts_.at(burst.request).activated = true;
    ++activates_;
  }
  void begin_response(Cycle now, unsigned slice) {
    const auto own = std::find_if(done_.begin(), done_.end(),
                                  [&](const auto& done) { return map_.slice(done.second.address) == slice; });
    if (own == done_.end() || own->first.first > now) return;
    DramSocket& socket = sockets_[slice];
    if (socket.response_used && memory_.first_after(socket.response_ends) > now) return;
    socket.response_used = true;
    socket.responses.emplace_back(memory_.edge(now), own->second);
    socket.response_ends = memory_.edge(now) + core_.period;
    done_.erase(own);
    ++responses_;
  }

  Config config_;
  const SliceMap& map_;
  Clock memory_, core_;
  std::vector<unsigned> slices_;
  std::deque<DramSocket>& sockets_;
  std::size_t turn_ = 0;  ///< in slices_
  bool refused_ = false;  ///< its request found no room and keeps its turn
  std::vector<Bank> banks_;
  std::deque<Burst> bursts_;                                ///< oldest first
  std::map<std::uint64_t, Parts> parts_;                    ///< by request
  std::map<std::pair<Cycle, std::uint64_t>, Access> done_;  ///< by the clock in which the response may begin
  std::uint64_t order_ = 0;
  Cycle read_from_ = 0, write_from_ = 0, activate_from_ = 0;  ///< of the whole channel

  std::uint64_t reads_ = 0, writes_ = 0, bytes_ = 0, responses_ = 0;
  std::uint64_t row_hits_ = 0, row_misses_ = 0, row_conflicts_ = 0, activates_ = 0, precharges_ = 0, columns_ = 0;
  std::uint64_t aged_ = 0, queue_clocks_ = 0, queue_full_ = 0;
  Distribution latency_;
};

}  // namespace grtx::sim::plain
