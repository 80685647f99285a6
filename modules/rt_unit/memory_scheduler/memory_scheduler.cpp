// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/memory_scheduler/memory_scheduler.h"

#include <algorithm>
#include <cassert>
#include <numeric>
#include <ostream>
#include <string>
#include <utility>

#include "grtx/base/error.h"
#include "grtx/modules/kernel/make_anew.h"
#include "grtx/modules/kernel/unit_fault.h"
#include "grtx/modules/rt_unit/memory_scheduler/decide/issue_order.h"

namespace grtx::modules {

namespace {

// Kept out of respond(), which the compiler inlines if it is short.
[[noreturn, gnu::cold, gnu::noinline]] void report_unasked(const char* unit, LaneId id) {
  unit_fault(unit, "the L1 has answered a node request of lane " + std::to_string(id) + ", which made none");
}

}  // namespace

std::uint64_t MemorySchedulerCounters::node_visits() const {
  return std::accumulate(visits.begin(), visits.end(), std::uint64_t{0});
}
std::uint64_t MemorySchedulerCounters::node_fetches() const {
  return std::accumulate(fetches.begin(), fetches.end(), std::uint64_t{0});
}
std::uint64_t MemorySchedulerCounters::node_sectors() const {
  return std::accumulate(sectors.begin(), sectors.end(), std::uint64_t{0});
}

const CounterTable<MemorySchedulerCounters>& MemorySchedulerCounters::table() {
  using C = MemorySchedulerCounters;
  using Column = CounterColumn<decltype(&C::visits)>;
  static const CounterTable<C> table =
      CounterTable<C>()
          .value(&C::node_visits, "node_visits", "visits", "lane visits of nodes replayed", StatisticKind::exact)
          .value(&C::node_fetches, "node_fetches", "fetches", "node fetches after merging equal addresses of a warp",
                 StatisticKind::count)
          .value(&C::node_sectors, "node_sectors", "requests", "32 B sector requests sent for node fetches",
                 StatisticKind::count)
          .by_name<Region>(is_node, Column{&C::visits, "node_visits", "visits", "lane visits of nodes in region {}"},
                           Column{&C::fetches, "node_fetches", "fetches", "node fetches in region {}"},
                           Column{&C::sectors, "node_sectors", "requests", "sector requests in region {}"})
          .sum(&C::shader_batches, "shader_fetch.batches", "batches", "node fetch calls to the SIMT core")
          .sum(&C::shader_sectors, "shader_fetch.sectors", "sectors", "node sectors read by the SIMT core")
          .distribution(&C::fetch_latency, "node_fetch_latency", "cycles",
                        "mean time from the visit until the last sector of the fetch is back", "longest node fetch");
  return table;
}

MemoryScheduler::MemoryScheduler(const sc_core::sc_module_name& name, const Config& config,
                                 const traces::Header& header, unsigned entries, bool holds_nodes)
    : NodeFetchModule(name),
      config_(config),
      header_(header),
      traffic_(header, config.traffic),
      holds_nodes_(holds_nodes),
      reads_twice_(config.traffic.descriptor_wait != 0 || config.traffic.header_wait != 0),
      fetches_(std::size_t{entries} * kMaxLanes),
      under_way_(entries),
      queue_(config.queue > 0 ? config.queue : 1),
      merge_(entries, config.merge_in_flight) {
  awake_ = false;
  require_allowed("rt.memory", config);
}

void MemoryScheduler::end_of_elaboration() {
  warps_ = &warp_buffer->warps();
  fetched_node_ = fetched_node.operator->();
  requests_ = writer_of(request);
  responses_ = reader_of(response);
  batches_ = writer_of(batch);
  batches_done_ = reader_of(batch_done);
  if (l1_reads.size() > 0) l1_ = l1_reads.operator->();
  if (config_.asks_at_once() && l1_ == nullptr) {
    throw Error("RT unit", name(), "needs the L1 at its port l1_reads for rt.memory.l1_hit_latency");
  }
  const bool bound = config_.by_shader ? batches_ && batches_done_ : requests_ && responses_;
  if (!bound) throw Error("RT unit", name(), "needs its memory ports, or those of the SIMT core when by_shader");
}

void MemoryScheduler::restart() {
  make_anew(traffic_, header_, config_.traffic);
  merge_ = FetchMerge(static_cast<unsigned>(under_way_.size()), config_.merge_in_flight);
  std::fill(fetches_.begin(), fetches_.end(), Fetch());
  std::fill(under_way_.begin(), under_way_.end(), 0);
  queue_.clear();
  awake_ = false;
  front_.reset();
  hits_.clear();
  second_reads_.clear();
  outstanding_ = 0;
  counters_ = {};
}

void MemoryScheduler::begin_warp(Cycle now, unsigned entry) {
  assert(has_room());
  now_ = now;
  merge_.begin_warp(entry);
}

void MemoryScheduler::visit(LaneId id, traces::NodeKind kind, std::uint64_t address, bool header) {
  const NodeVisit node{kind, address, header};
  const NodePart part = reads_twice_ && wait_of(node, traffic_) != 0 ? NodePart::first : NodePart::whole;
  const NodeSectors sectors(node, traffic_, part);
  ++counters_.visits[static_cast<std::size_t>(sectors.region())];
  const LaneMask lane = bit(lane_of(id));
  const std::uint64_t key = FetchMerge::key(node, part, traffic_);
  if (!join(id, lane, node, part, key)) open(id, {node, lane, now_, part}, sectors, key);
}

/// Whether a fetch under way serves these lanes, too.
[[gnu::always_inline]] inline bool MemoryScheduler::join(LaneId id, LaneMask lanes, const NodeVisit& node,
                                                         NodePart part, std::uint64_t key) {
  const std::uint32_t under_way = merge_.find(entry_of(id), key, part);
  if (under_way == FetchMerge::kNone) return false;
  if (fetches_[under_way].node.kind != node.kind) {  // only in an inconsistent trace
    throw Error("trace", place_in_trace(warps_->warp(entry_of(id)), lane_of(id)),
                "the node at byte " + std::to_string(node.address) + " is of two kinds");
  }
  fetches_[under_way].lanes |= lanes;
  return true;
}

[[gnu::always_inline]] inline void MemoryScheduler::open(LaneId id, const Fetch& fetch, const NodeSectors& sectors,
                                                         std::uint64_t key) {
  merge_.begin(id, key, fetch.part);
  ++counters_.fetches[static_cast<std::size_t>(sectors.region())];
  fetches_[id] = fetch;
  fetches_[id].sectors = fetches_[id].missing = static_cast<std::uint8_t>(sectors.count());
  under_way_[entry_of(id)] |= bit(lane_of(id));
  queue_.push({id, 0});
  if (config_.oldest_warp_first) put_behind_older_warps();
  awake_ = true;
}

/// Moves the last fetch of the queue before those of younger warps.
[[gnu::noinline]] void MemoryScheduler::put_behind_older_warps() {
  const auto at = [&](std::size_t i) {
    const Pending& waiting = queue_.at(i);
    return WaitingFetch{warps_->ages()[entry_of(waiting.fetch)], waiting.next != 0};
  };
  const std::size_t last = queue_.size() - 1;
  const std::size_t place = oldest_first_place(at(last).age, last, at);
  for (std::size_t i = last; i > place; --i) std::swap(queue_.at(i - 1), queue_.at(i));
}

// The leading lane's record is free: its first read is over.
[[gnu::noinline]] void MemoryScheduler::begin_second_reads(Cycle now) {
  auto read = second_reads_.begin();
  for (; read != second_reads_.end() && read->due <= now && queue_.room() > 0; ++read) {
    const LaneId id = lane_id(read->entry, static_cast<unsigned>(std::countr_zero(read->lanes)));
    const NodeSectors sectors(read->node, traffic_, NodePart::second);
    const std::uint64_t key = FetchMerge::key(read->node, NodePart::second, traffic_);
    if (join(id, read->lanes, read->node, NodePart::second, key)) continue;
    open(id, {read->node, read->lanes, now, NodePart::second}, sectors, key);
  }
  second_reads_.erase(second_reads_.begin(), read);
}

void MemoryScheduler::count_visit(const NodeVisit& node) {
  ++counters_.visits[index(traffic_.region(node.kind, node.address))];
}

void MemoryScheduler::issue(Cycle now) {
  if (!hits_.empty()) take_hits(now);
  if (!second_reads_.empty()) begin_second_reads(now);
  if (!queue_.empty()) config_.by_shader ? issue_batch(now) : issue_sectors(now);
  awake_ = busy();
}

inline void MemoryScheduler::issue_sectors(Cycle now) {
  for (unsigned i = 0; i < config_.sectors_per_cycle && !queue_.empty(); ++i) {
    Pending& p = queue_.front();
    if (p.next == 0) front_.emplace(fetches_[p.fetch].node, traffic_, fetches_[p.fetch].part);
    const SectorAccess sector = front_->at(p.next);
    MemoryRequest message;
    message.address = sector.address;
    message.tag = p.fetch;
    message.region = sector.region;
    if (!request_sector(now, message)) return;
    ++counters_.sectors[static_cast<std::size_t>(sector.region)];
    ++outstanding_;
    if (++p.next == front_->count()) queue_.pop();
    if (config_.l1_hit_latency == 0) take_hits(now);
  }
}

inline bool MemoryScheduler::request_sector(Cycle now, const MemoryRequest& sector) {
  if (l1_ == nullptr) return requests_.try_push(now, sector);
  const ReadAtOnce found = l1_->read_at_once(now, sector);
  if (found == ReadAtOnce::hit) hits_.push({now + config_.l1_hit_latency, static_cast<LaneId>(sector.tag)});
  return found != ReadAtOnce::refused;
}

[[gnu::noinline]] void MemoryScheduler::take_hits(Cycle now) {
  while (!hits_.empty() && hits_.front().due <= now) {
    const LaneId id = hits_.front().fetch;
    hits_.pop();
    take_sector(now, id);
  }
}

void MemoryScheduler::issue_batch(Cycle now) {
  if (!batches_.can_push(now)) return;
  const unsigned entry = entry_of(queue_.front().fetch);
  batches_.push(now, take_batch(entry, warps_->warp(entry).slot));
}

NodeFetchBatch MemoryScheduler::take_batch(unsigned entry, std::uint16_t slot) {
  NodeFetchBatch message;
  message.slot = slot;
  message.entry = static_cast<std::uint16_t>(entry);
  for (; !queue_.empty() && entry_of(queue_.front().fetch) == entry; queue_.pop()) {
    const LaneId id = queue_.front().fetch;
    const Fetch& f = fetches_[id];
    const NodeSectors sectors(f.node, traffic_, f.part);
    message.fetches |= bit(lane_of(id));
    for (unsigned s = 0; s < f.sectors; ++s) {
      message.sectors.push_back(sectors.at(s));
      ++counters_.sectors[static_cast<std::size_t>(message.sectors.back().region)];
    }
    outstanding_ += f.sectors;
    counters_.shader_sectors += f.sectors;
  }
  ++counters_.shader_batches;
  return message;
}

void MemoryScheduler::respond(Cycle now) {
  if (config_.by_shader) return take_batch_done(now);
  for (unsigned i = 0; i < config_.sectors_per_cycle; ++i) {
    const MemoryResponse* arrived = responses_.front(now);
    if (arrived == nullptr) return;
    const auto id = static_cast<LaneId>(arrived->tag);
    responses_.pop(now);
    if (id >= fetches_.size() || fetches_[id].missing == 0) [[unlikely]]
      report_unasked(name(), id);
    take_sector(now, id);
  }
}

inline void MemoryScheduler::take_sector(Cycle now, LaneId id) {
  --outstanding_;
  if (--fetches_[id].missing == 0) complete(now, id);
}

void MemoryScheduler::take_batch_done(Cycle now) {
  const NodeFetchDone* front = batches_done_.front(now);
  if (front == nullptr) return;
  const NodeFetchDone done = *front;
  batches_done_.pop(now);
  for_each_bit(done.fetches, [&](unsigned lane) {
    const LaneId id = lane_id(done.entry, lane);
    outstanding_ -= fetches_[id].missing;
    fetches_[id].missing = 0;
    complete(now, id);
  });
}

[[gnu::noinline]] void MemoryScheduler::complete(Cycle now, LaneId id) {
  Fetch& f = fetches_[id];
  counters_.fetch_latency.add(now - f.asked);
  under_way_[entry_of(id)] &= ~bit(lane_of(id));
  merge_.end(id, FetchMerge::key(f.node, f.part, traffic_));
  const LaneMask lanes = f.lanes;
  f.lanes = 0;
  if (f.part == NodePart::first) {
    const SecondRead read{now + wait_of(f.node, traffic_), entry_of(id), lanes, f.node};
    const auto later = [](const SecondRead& a, const SecondRead& b) { return a.due < b.due; };
    second_reads_.insert(std::upper_bound(second_reads_.begin(), second_reads_.end(), read, later), read);
    awake_ = true;
    return;
  }
  fetched_node_->fetched(now, entry_of(id), lanes, f.node.kind);
}

std::vector<UnitProbe> MemoryScheduler::probes() const {
  return {{"queued", kLevelBits, [this] { return queued(); }},
          {"outstanding", kLevelBits, [this] { return outstanding(); }},
          {"node_sectors", kCounterBits, [this] { return counters_.node_sectors(); }, {}, true}};
}

Inventory MemoryScheduler::inventory() const {
  Inventory inventory{name(), {}, {}};
  // A record: lanes, node address (48 bits), kind, sectors still missing.
  inventory.storage.push_back({"fetches", StorageKind::ram, fetches_.size() * (kMaxLanes + 48 + 3 + 4)});
  if (holds_nodes_ && config_.node_ports != 0) {
    const traces::NodeSizes sizes = header_.node_sizes();
    const auto node_bits = static_cast<unsigned>(
        8 * std::max(sizes.read_bytes(traces::NodeKind::internal), sizes.read_bytes(traffic_.leaf_kind())));
    const unsigned ports = config_.node_ports * (header_.two_level ? 3 : 2);  // of each unit that reads
    inventory.storage.push_back({"nodes", StorageKind::ram, fetches_.size() * node_bits, ports, 1, false, node_bits});
  }
  inventory.storage.push_back({"queue", StorageKind::flip_flop, std::uint64_t{config_.queue} * (8 + 3)});
  inventory.operators.push_back({"match", 48, std::uint64_t{kMaxLanes} * (kMaxLanes - 1) / 2});
  return inventory;
}

void MemoryScheduler::dump_state(std::ostream& out) const {
  out << name() << ": " << queue_.size() << " fetches to issue, " << outstanding_ << " sectors outstanding\n";
  for (std::size_t e = 0; e < under_way_.size(); ++e) {
    for_each_bit(under_way_[e], [&](unsigned lane) {
      const Fetch& f = fetches_[e * kMaxLanes + lane];
      out << "  entry " << e << " lane " << lane << " node " << f.node.address << " lanes " << std::popcount(f.lanes)
          << " missing " << unsigned{f.missing} << " since " << f.asked << '\n';
    });
  }
}

PartInfo part_info(const MemorySchedulerConfig& config, bool walks) {
  PartInfo part;
  part.name = "memory_scheduler";
  if (!walks && config.node_ports != 0) {
    part.energy = {{.name = "rt.memory.nodes",
                    .statistics = {"gpu.rt.node_fetches"},
                    .terms = {writes(part.name, "nodes"), reads(part.name, "nodes")},
                    .basis = "nodes that have been fetched, in and out"}};
  }
  part.title = "memory scheduler";
  part.statistics = {"gpu.rt.node_", "gpu.rt.merge_", "gpu.rt.shader_fetch."};
  part.keys = {"rt.memory"};
  part.bounds = {{.name = "rt_port",
                  .statistics = {"gpu.rt.node_sectors"},
                  .rate = config.sectors_per_cycle,
                  .limit = PartBound::Limit::port,
                  .description = "node sectors of the busiest RT unit over the width of its port",
                  .words = "the port of the RT units to the L1"}};
  part.stalls = {{"memory", "nodes under way"}, {"queue_full", "their port to the L1"}};
  return part;
}

}  // namespace grtx::modules
