// SPDX-License-Identifier: Apache-2.0
// Plain DRAM channel with its side of the sockets: docs/model/dram.md, and docs/model/tlm.md for the phases.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <map>
#include <utility>
#include <vector>

#include "grtx/modules/dram/decide/dram_channel.h"
#include "grtx/modules/dram/dram.h"
#include "rtl_tlm/plain/address_map.h"
#include "rtl_tlm/plain/dram_commands.h"
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
        commands_(config.channel) {}

  void tick(Cycle now) {
    take_requests(now);
    if (!config_.perfect) issue_commands(now);
    queue_clocks_ += commands_.queued();
    for (const unsigned slice : slices_) begin_response(now, slice);
  }
  bool idle() const {
    const auto quiet = [this](unsigned slice) { return !sockets_[slice].request && sockets_[slice].responses.empty(); };
    return commands_.queued() == 0 && done_.empty() && std::all_of(slices_.begin(), slices_.end(), quiet);
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
    s.add("gpu.dram.precharges", precharges_ + commands_.refresh_precharges());
    s.add("gpu.dram.refreshes", commands_.refreshes());
    s.add("gpu.dram.bursts", columns_);
    s.add("gpu.dram.aged", aged_);
    s.add("gpu.dram.queue_clocks", queue_clocks_);
    s.add("gpu.dram.queue_full_clocks", queue_full_);
    s.add("gpu.dram.access_latency.count", latency_.count);
    s.add("gpu.dram.access_latency.sum", latency_.sum);
  }

 private:
  /// What a request still waits for, and which commands it needed.
  struct Parts {
    Access access;
    std::uint64_t left;
    bool activated, precharged;
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
    refused_ = commands_.queued() + bursts > config_.channel.queue;
    if (refused_) {
      ++queue_full_;
      return;
    }
    const Access access = end_request(now, slices_[turn_]);
    turn_ = (turn_ + 1) % slices_.size();
    parts_[order_] = {access, bursts, false, false};
    for (std::uint64_t b = 0; b < bursts; ++b) {
      commands_.enqueue(now, order_, map_.in_channel(access.address), access.write);
    }
    ++order_;
  }
  void issue_commands(Cycle now) {
    const DramCommands::Issued issued = commands_.step(now);
    if (issued.row) {
      ++(issued.precharge ? precharges_ : activates_);
      Parts& parts = parts_.at(issued.row->request);
      (issued.precharge ? parts.precharged : parts.activated) = true;
    }
    if (!issued.column) return;
    ++columns_;
    const Parts& parts = parts_.at(issued.column->request);
    if (--parts_.at(issued.column->request).left > 0) return;
    ++(parts.precharged ? row_conflicts_ : parts.activated ? row_misses_ : row_hits_);
    latency_.add(issued.done - issued.column->arrival);
    aged_ += commands_.aged(*issued.column, now) ? 1 : 0;
    done_.emplace(std::pair{issued.done + config_.fixed_latency, order_++}, parts.access);
    parts_.erase(issued.column->request);
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
  DramCommands commands_;
  std::map<std::uint64_t, Parts> parts_;                    ///< by request
  std::map<std::pair<Cycle, std::uint64_t>, Access> done_;  ///< by the clock in which the response may begin
  std::uint64_t order_ = 0;

  std::uint64_t reads_ = 0, writes_ = 0, bytes_ = 0, responses_ = 0;
  std::uint64_t row_hits_ = 0, row_misses_ = 0, row_conflicts_ = 0, activates_ = 0, precharges_ = 0, columns_ = 0;
  std::uint64_t aged_ = 0, queue_clocks_ = 0, queue_full_ = 0;
  Distribution latency_;
};

}  // namespace grtx::sim::plain
