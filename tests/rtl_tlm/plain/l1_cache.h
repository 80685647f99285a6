// SPDX-License-Identifier: Apache-2.0
// Plain L1 data cache: docs/model/l1_cache.md.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "grtx/modules/cache/l1_cache.h"
#include "rtl_tlm/plain/cache_counts.h"
#include "rtl_tlm/plain/cache_lines.h"
#include "rtl_tlm/plain/messages.h"
#include "rtl_tlm/plain/statistics.h"

namespace grtx::sim::plain {

class L1Cache {
 public:
  using Config = modules::L1Cache::Config;
  struct Port {
    MemoryPort* port;
    unsigned width;  ///< sectors per cycle
  };
  L1Cache(const Config& config, unsigned sm, unsigned link_latency, const std::vector<Port>& clients,
          Channel<Access>& to_memory, Channel<Access>& from_memory)
      : config_(config),
        sm_(sm),
        link_latency_(link_latency),
        to_memory_(to_memory),
        from_memory_(from_memory),
        lines_({config.geometry.bytes, config.geometry.line_bytes, config.geometry.ways, config.geometry.replacement}) {
    for (const Port& port : clients) clients_.push_back({port.port, port.width, {}, {}});
  }

  void tick(Cycle now) {
    take_fill(now);
    take_requests(now);
    send_miss(now);
    send_responses(now);
    mshr_cycles_ += mshrs_.size();
  }
  /// The first client's read without a link, behind tick(now): whether the sector is here. Nothing where the read
  /// cannot be taken.
  std::optional<bool> read_at_once(Cycle now, Access access) {
    access.client = 0;
    access.sm = sm_;
    auto& hits = clients_[0].hits;
    const std::size_t answers = hits.size(), entries = mshrs_.size();
    if (!read(now, clients_[0], access)) return std::nullopt;
    ++accesses_;
    lines_.use(access.address);
    mshr_cycles_ += mshrs_.size() - entries;
    if (hits.size() == answers) return false;
    hits.pop_back();
    ++responses_;
    return true;
  }
  bool idle() const {
    return mshrs_.empty() && misses_.empty() && writes_pending_ == 0 &&
           std::all_of(clients_.begin(), clients_.end(),
                       [](const Client& c) { return c.hits.empty() && c.fills.empty() && c.port->request.empty(); });
  }
  void report(Statistics& s) const {
    counts_.report(s, "gpu.l1");
    s.add("gpu.l1.accesses", accesses_);
    s.add("gpu.l1.responses", responses_);
    s.add("gpu.l1.stall.response_port", stalls_.response_port);
    s.add("gpu.l1.stall.bank_conflict", stalls_.bank_conflict);
    s.add("gpu.l1.stall.mshr_full", stalls_.mshr_full);
    s.add("gpu.l1.stall.merges_full", stalls_.merges_full);
    s.add("gpu.l1.stall.miss_queue_full", stalls_.miss_queue_full);
    s.add("gpu.l1.prefetch.requests", prefetches_.redundant + prefetches_.fetched);
    s.add("gpu.l1.prefetch.redundant", prefetches_.redundant);
    s.add("gpu.l1.prefetch.fetched", prefetches_.fetched);
    s.add("gpu.l1.prefetch.useful", prefetches_.useful);
    s.add("gpu.l1.prefetch.late", prefetches_.late);
    std::uint64_t resident = 0;
    lines_.for_each_sector([&](const CacheLines::Sector& sector) { resident += sector.prefetched ? 1 : 0; });
    s.add("gpu.l1.prefetch.unused", prefetches_.unused + resident);
    s.add("gpu.l1.fills", fills_);
    s.add("gpu.l1.evictions", evictions_);
    s.add("gpu.l1.sent_reads", sent_reads_);
    s.add("gpu.l1.sent_writes", sent_writes_);
    s.add("gpu.l1.fills_bypassed", fills_bypassed_);
    s.add("gpu.l1.kept_writes", kept_writes_);
    s.add("gpu.l1.rewrites", rewrites_);
    s.add("gpu.l1.write_backs", write_backs_);
    s.add("gpu.l1.mshr_cycles", mshr_cycles_);
    s.add("gpu.l1.miss_latency", miss_latency_);
  }

 private:
  static constexpr unsigned kNobody = ~0U;  ///< client of a write-back, whose acknowledgement nobody gets

  struct Client {
    MemoryPort* port;
    unsigned width;
    std::deque<std::pair<Cycle, Access>> hits;   ///< with the cycle in which the answer may enter the link
    std::deque<std::pair<Cycle, Access>> fills;  ///< answers of fills and write acknowledgements
  };
  struct Mshr {
    std::vector<Access> waiting;  ///< oldest first
    Cycle allocated = 0;
    bool prefetched = false;  ///< by a prefetch, and no demand read has come to it
  };

  void take_fill(Cycle now) {
    if (from_memory_.front(now) == nullptr) return;
    const Access answer = from_memory_.pop(now);
    if (answer.write) {
      --writes_pending_;
      if (answer.client != kNobody) clients_[answer.client].fills.emplace_back(now, answer);
      return;
    }
    const Mshr mshr = mshrs_.at(answer.address);
    mshrs_.erase(answer.address);
    ++fills_;
    miss_latency_.add(now - mshr.allocated);
    for (const Access& waiter : mshr.waiting) clients_[waiter.client].fills.emplace_back(now, waiter);
    CacheLines::Line* line = lines_.line(answer.address);
    CacheLines::Line* place = nullptr;
    if (line == nullptr) {
      place = victim_can_leave(answer.address) ? &lines_.place(answer.address) : lines_.clean_place(answer.address);
    }
    if (line == nullptr && place == nullptr) {
      ++fills_bypassed_;
      prefetches_.unused += mshr.prefetched ? 1 : 0;
      return;
    }
    if (line == nullptr) line = &take_line(now, *place, answer.address);
    CacheLines::Sector& sector = lines_.at(*line, answer.address);
    sector.valid = true;
    sector.prefetched = mshr.prefetched;
  }
  /// Whether there is a place in the write-back buffer for the line whose place the address would take, if it needs
  /// one.
  bool victim_can_leave(std::uint64_t address) {
    return lines_.dirty_sectors(lines_.place(address)).empty() || leaving_.size() < config_.write_back_buffer;
  }
  /// Misses and writes in the miss queue: what waits for the crossbar but is not in the write-back buffer.
  std::size_t queued() const {
    return static_cast<std::size_t>(
        std::count_if(misses_.begin(), misses_.end(), [](const auto& miss) { return miss.second.client != kNobody; }));
  }
  /// A line for the address; the one that leaves goes to the write-back buffer if it is dirty.
  CacheLines::Line& take_line(Cycle now, CacheLines::Line& line, std::uint64_t address) {
    if (line.used) {
      ++evictions_;
      for (const auto& sector : line.sectors) prefetches_.unused += sector.valid && sector.prefetched ? 1 : 0;
      const std::vector<std::uint64_t> dirty = lines_.dirty_sectors(line);
      if (!dirty.empty()) leaving_.push_back(dirty.size());
      for (const std::uint64_t sector : dirty) {
        misses_.emplace_back(now + config_.tag_latency, Access{sector, line.writer, true, false, 0, kNobody, sm_});
        ++writes_pending_;
        ++write_backs_;
      }
    }
    lines_.put(line, address);
    return line;
  }

  void take_requests(Cycle now) {
    banks_taken_.assign(config_.banks, false);
    bool won = false;
    const std::size_t first = config_.rotating_priority ? next_first_ : 0;
    for (std::size_t i = 0; i < clients_.size(); ++i) {
      const std::size_t number = (first + i) % clients_.size();
      Client& client = clients_[number];
      for (unsigned taken = 0; taken < client.width && client.port->request.front(now) != nullptr; ++taken) {
        Access access = *client.port->request.front(now);
        access.client = static_cast<unsigned>(number);
        access.sm = sm_;
        if (!accept(now, client, access)) break;
        client.port->request.pop(now);
        ++accesses_;
        if (!won) next_first_ = (number + 1) % clients_.size();
        won = true;
      }
    }
  }
  bool accept(Cycle now, Client& client, const Access& access) {
    if (client.hits.size() >= config_.latency * client.width) return refuse(stalls_.response_port);
    const std::size_t bank = access.address / kSector % config_.banks;
    if (banks_taken_[bank]) return refuse(stalls_.bank_conflict);
    const bool accepted = access.write ? write(now, client, access) : read(now, client, access);
    if (!accepted) return false;
    banks_taken_[bank] = true;
    lines_.use(access.address);
    return true;
  }
  bool read(Cycle now, Client& client, const Access& access) {
    CacheLines::Sector* sector = lines_.sector(access.address);
    const auto pending = mshrs_.find(access.address);
    if (config_.perfect || sector != nullptr) {
      answer(now, client, access);
      if (sector != nullptr && !access.prefetch && std::exchange(sector->prefetched, false)) ++prefetches_.useful;
      if (access.prefetch) {
        ++prefetches_.redundant;
      } else {
        ++counts_[access.region].hits;
      }
      return true;
    }
    if (pending != mshrs_.end()) {
      Mshr& mshr = pending->second;
      if (mshr.waiting.size() >= config_.mshr_merges) return refuse(stalls_.merges_full);
      mshr.waiting.push_back(access);
      if (access.prefetch) {
        ++prefetches_.redundant;
      } else {
        ++counts_[access.region].hits_on_miss;
        if (std::exchange(mshr.prefetched, false)) ++prefetches_.late;
      }
      return true;
    }
    if (mshrs_.size() >= config_.mshr_entries) return refuse(stalls_.mshr_full);
    if (queued() >= config_.miss_queue) return refuse(stalls_.miss_queue_full);
    mshrs_[access.address] = {{access}, now, access.prefetch};
    misses_.emplace_back(now + config_.tag_latency, access);
    if (access.prefetch) {
      ++prefetches_.fetched;
    } else {
      ++counts_[access.region].misses;
    }
    return true;
  }
  bool write(Cycle now, Client& client, const Access& access) {
    if (config_.perfect) {
      answer(now, client, access);
      ++counts_[access.region].writes;
      ++counts_[access.region].write_hits;
      return true;
    }
    CacheLines::Line* line = lines_.line(access.address);
    // Whether the sector is kept in the L1, and whether the write goes on to the L2.
    const bool back = config_.private_writes.policy == modules::WritePolicy::write_back;
    const bool is_private = access.region == Region::checkpoint || access.region == Region::eviction ||
                            access.region == Region::k_buffer || access.region == Region::stack;
    const bool kept = is_private && (config_.private_writes.allocate || (back && line != nullptr));
    const bool dirty = kept && back;
    if (!dirty && queued() >= config_.miss_queue) return refuse(stalls_.miss_queue_full);
    if (kept && line == nullptr && !victim_can_leave(access.address)) return refuse(stalls_.miss_queue_full);

    ++counts_[access.region].writes;
    if (lines_.sector(access.address) != nullptr) {
      ++counts_[access.region].write_hits;
      if (std::exchange(lines_.sector(access.address)->prefetched, false)) ++prefetches_.useful;
    }
    if (kept) {
      if (line == nullptr) line = &take_line(now, lines_.place(access.address), access.address);
      CacheLines::Sector& sector = lines_.at(*line, access.address);
      sector.valid = true;
      if (dirty) {
        ++kept_writes_;
        rewrites_ += std::exchange(sector.dirty, true) ? 1 : 0;
        line->writer = access.region;
      }
    }
    if (dirty) {
      answer(now, client, access);
    } else {
      misses_.emplace_back(now + config_.tag_latency, access);
      ++writes_pending_;
    }
    return true;
  }
  void answer(Cycle now, Client& client, const Access& access) const {
    client.hits.emplace_back(now + config_.latency - link_latency_, access);
  }
  static bool refuse(std::uint64_t& reason) {
    ++reason;
    return false;
  }

  void send_miss(Cycle now) {
    if (misses_.empty() || misses_.front().first > now || !to_memory_.has_room(now)) return;
    ++(misses_.front().second.write ? sent_writes_ : sent_reads_);
    to_memory_.push(now, misses_.front().second);
    if (misses_.front().second.client == kNobody && --leaving_.front() == 0) leaving_.pop_front();
    misses_.pop_front();
  }

  void send_responses(Cycle now) {
    for (Client& client : clients_) {
      for (unsigned sent = 0; sent < client.width && client.port->response.has_room(now); ++sent) {
        const auto due = [now](const auto& queue) { return !queue.empty() && queue.front().first <= now; };
        auto* queue = due(client.hits) ? &client.hits : due(client.fills) ? &client.fills : nullptr;
        if (due(client.hits) && due(client.fills) && client.fills.front().first < client.hits.front().first) {
          queue = &client.fills;  // what has been due longer
        }
        if (queue == nullptr) break;
        client.port->response.push(now, queue->front().second);
        queue->pop_front();
        ++responses_;
      }
    }
  }

  Config config_;
  unsigned sm_, link_latency_;
  Channel<Access>& to_memory_;
  Channel<Access>& from_memory_;
  std::vector<Client> clients_;
  CacheLines lines_;
  std::map<std::uint64_t, Mshr> mshrs_;          ///< by sector
  std::deque<std::pair<Cycle, Access>> misses_;  ///< and sectors of the write-back buffer, in the order of leaving
  std::deque<std::size_t> leaving_;              ///< lines of the write-back buffer: sectors that have not left
  std::vector<bool> banks_taken_;
  std::size_t next_first_ = 0;
  std::uint64_t writes_pending_ = 0;

  CacheCounts counts_;
  struct {
    std::uint64_t response_port = 0, bank_conflict = 0, mshr_full = 0, merges_full = 0, miss_queue_full = 0;
  } stalls_;
  struct {
    std::uint64_t redundant = 0, fetched = 0, useful = 0, late = 0, unused = 0;
  } prefetches_;
  std::uint64_t accesses_ = 0, responses_ = 0, fills_ = 0, evictions_ = 0, sent_reads_ = 0, sent_writes_ = 0;
  std::uint64_t fills_bypassed_ = 0, kept_writes_ = 0, rewrites_ = 0, write_backs_ = 0, mshr_cycles_ = 0;
  Distribution miss_latency_;
};

}  // namespace grtx::sim::plain
