// SPDX-License-Identifier: Apache-2.0
// Plain L2 slice: docs/model/l2_slice.md, and docs/model/tlm.md for its socket.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <utility>
#include <vector>

#include "grtx/modules/cache/l2_slice.h"
#include "rtl_tlm/plain/address_map.h"
#include "rtl_tlm/plain/cache_counts.h"
#include "rtl_tlm/plain/cache_lines.h"
#include "rtl_tlm/plain/dram_socket.h"
#include "rtl_tlm/plain/statistics.h"

namespace grtx::sim::plain {

class L2Slice {
 public:
  using Config = modules::L2Slice::Config;
  /// bytes: of this slice.
  L2Slice(const Config& config, std::uint64_t bytes, unsigned slice, const SliceMap& map, Clock core,
          Channel<Access>& request, Channel<Access>& response, DramSocket& dram)
      : config_(config),
        slice_(slice),
        map_(map),
        core_(core),
        request_(request),
        response_(response),
        dram_(dram),
        lines_({bytes, config.geometry.line_bytes, config.geometry.ways, config.geometry.replacement}) {}

  void tick(Cycle now) {
    take_completion(now);
    take_request(now);
    probe(now);
    send_to_dram(now);
    send_reply(now);
    mshr_cycles_ += mshrs_.size();
  }
  bool idle() const {
    return inside_.empty() && mshrs_.empty() && replies_.empty() && to_dram_.empty() && dram_outstanding_ == 0;
  }
  void report(Statistics& s) const {
    counts_.report(s, "gpu.l2");
    s.add("gpu.l2.accesses", accesses_);
    s.add("gpu.l2.stall.reply_queue", stalls_.reply_queue);
    s.add("gpu.l2.stall.mshr_full", stalls_.mshr_full);
    s.add("gpu.l2.stall.merges_full", stalls_.merges_full);
    s.add("gpu.l2.stall.dram_queue", stalls_.dram_queue);
    s.add("gpu.l2.stall.fill", stalls_.fill);
    for (std::size_t r = 0; r < modules::kRegionCount; ++r) {
      for (const std::string& name : {std::string(), "." + std::string(name_at<modules::Region>(r))}) {
        s.add("gpu.l2.dram_reads" + name, dram_reads_[r]);
        s.add("gpu.l2.dram_writes" + name, dram_writes_[r]);
      }
    }
    s.add("gpu.l2.evictions", evictions_);
    s.add("gpu.l2.mshr_cycles", mshr_cycles_);
    s.add("gpu.l2.miss_latency", miss_latency_);
    std::uint64_t dirty = 0;
    lines_.for_each_sector([&](const CacheLines::Sector& sector) { dirty += sector.dirty ? 1 : 0; });
    s.add("gpu.l2.dirty_at_end", dirty);
  }
  static void finish(Statistics& s) {
    CacheCounts::finish(s, "gpu.l2");
    s.finish_mean("gpu.l2.miss_latency");
    s.values["gpu.l2.hit_rate"] =
        Statistics::ratio(s["gpu.l2.all.hits"] + s["gpu.l2.all.write_hits"], s["gpu.l2.accesses"]);
    s.values["gpu.l2.read_hit_rate"] = s["gpu.l2.all.hit_rate"];
  }

 private:
  struct Mshr {
    std::vector<Access> waiting;
    Cycle allocated = 0;
  };

  void take_completion(Cycle now) {
    if (dram_.responses.empty() || core_.first_after(dram_.responses.front().first) > now) return;
    const Access answer = dram_.responses.front().second;
    if (!answer.write && !fill(now, answer)) {
      ++stalls_.fill;
      return;
    }
    dram_.responses.pop_front();
    --dram_outstanding_;
  }
  bool fill(Cycle now, const Access& answer) {
    const auto mshr = mshrs_.find(answer.address);
    if (replies_.size() + mshr->second.waiting.size() > config_.reply_queue) return false;
    CacheLines::Line* line = get_line(answer.address);
    if (line == nullptr) return false;
    lines_.at(*line, map_.local(answer.address)).valid = true;
    miss_latency_.add(now - mshr->second.allocated);
    for (const Access& waiter : mshr->second.waiting) replies_.push_back(waiter);
    mshrs_.erase(mshr);
    return true;
  }
  /// The line of the address, which takes another's place if need be; nullptr when the DRAM queue has no room for what
  /// that one has to write back.
  CacheLines::Line* get_line(std::uint64_t address) {
    const std::uint64_t local = map_.local(address);
    if (CacheLines::Line* line = lines_.line(local)) return line;
    CacheLines::Line& line = lines_.place(local);
    if (line.used) {
      const std::vector<std::uint64_t> dirty = lines_.dirty_sectors(line);
      if (to_dram_.size() + dirty.size() > config_.dram_queue) return nullptr;
      for (const std::uint64_t sector : dirty) to_dram_.push_back({map_.global(sector, slice_), line.writer, true});
      ++evictions_;
    }
    lines_.put(line, local);
    return &line;
  }

  void take_request(Cycle now) {
    if (request_.front(now) == nullptr || inside_.size() >= config_.latency + config_.queue) return;
    inside_.emplace_back(now + config_.latency, request_.pop(now));
  }
  void probe(Cycle now) {
    if (inside_.empty() || inside_.front().first > now) return;
    const Access access = inside_.front().second;
    if (!(access.write ? write(access) : read(now, access))) return;
    inside_.pop_front();
    lines_.use(map_.local(access.address));
    ++accesses_;
  }
  bool read(Cycle now, const Access& access) {
    if (config_.perfect || lines_.sector(map_.local(access.address)) != nullptr) {
      if (replies_.size() >= config_.reply_queue) return refuse(stalls_.reply_queue);
      replies_.push_back(access);
      ++counts_[access.region].hits;
      return true;
    }
    const auto pending = mshrs_.find(access.address);
    if (pending != mshrs_.end()) {
      if (pending->second.waiting.size() >= config_.mshr_merges) return refuse(stalls_.merges_full);
      pending->second.waiting.push_back(access);
      ++counts_[access.region].hits_on_miss;
      return true;
    }
    if (mshrs_.size() >= config_.mshr_entries) return refuse(stalls_.mshr_full);
    if (to_dram_.size() >= config_.dram_queue) return refuse(stalls_.dram_queue);
    mshrs_[access.address] = {{access}, now};
    to_dram_.push_back(access);
    ++counts_[access.region].misses;
    return true;
  }
  bool write(const Access& access) {
    if (replies_.size() >= config_.reply_queue) return refuse(stalls_.reply_queue);
    const bool hit = config_.perfect || lines_.sector(map_.local(access.address)) != nullptr;
    if (!config_.perfect) {
      CacheLines::Line* line = get_line(access.address);
      if (line == nullptr) return refuse(stalls_.dram_queue);
      CacheLines::Sector& sector = lines_.at(*line, map_.local(access.address));
      sector.valid = sector.dirty = true;
      line->writer = access.region;
    }
    ++counts_[access.region].writes;
    if (hit) ++counts_[access.region].write_hits;
    replies_.push_back(access);
    return true;
  }
  static bool refuse(std::uint64_t& reason) {
    ++reason;
    return false;
  }

  void send_to_dram(Cycle now) {
    if (to_dram_.empty() || dram_.request.has_value()) return;
    if (dram_.used && core_.first_after(dram_.request_ended) > now) return;
    dram_.request.emplace(core_.edge(now), to_dram_.front());
    dram_.used = true;
    ++(to_dram_.front().write ? dram_writes_ : dram_reads_)[modules::index(to_dram_.front().region)];
    ++dram_outstanding_;
    to_dram_.pop_front();
  }
  void send_reply(Cycle now) {
    if (replies_.empty() || !response_.has_room(now)) return;
    response_.push(now, replies_.front());
    replies_.pop_front();
  }

  Config config_;
  unsigned slice_;
  const SliceMap& map_;
  Clock core_;
  Channel<Access>& request_;
  Channel<Access>& response_;
  DramSocket& dram_;
  CacheLines lines_;  ///< by addresses inside the slice
  std::deque<std::pair<Cycle, Access>> inside_;
  std::map<std::uint64_t, Mshr> mshrs_;
  std::deque<Access> to_dram_, replies_;
  std::uint64_t dram_outstanding_ = 0;

  CacheCounts counts_;
  struct {
    std::uint64_t reply_queue = 0, mshr_full = 0, merges_full = 0, dram_queue = 0, fill = 0;
  } stalls_;
  std::array<std::uint64_t, modules::kRegionCount> dram_reads_{}, dram_writes_{};
  std::uint64_t accesses_ = 0, evictions_ = 0, mshr_cycles_ = 0;
  Distribution miss_latency_;
};

}  // namespace grtx::sim::plain
