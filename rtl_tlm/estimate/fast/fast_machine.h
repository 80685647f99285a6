// The machine of fast mode: its parts, and what happens in them. One number in the event wheel stands for each lane,
// each resident warp, each any-hit timer of a warp buffer entry, and each SM's L1 and warp scheduler.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/rt_unit/event_effect.h"
#include "grtx/modules/rt_unit/node_traffic.h"
#include "grtx/modules/rt_unit/node_visit.h"
#include "grtx/modules/rt_unit/sibling_records.h"
#include "grtx/modules/rt_unit/warp_selection.h"
#include "grtx/modules/simt/work_distributor.h"
#include "grtx/rtl_tlm/estimate/fast/fast_memory.h"
#include "grtx/rtl_tlm/estimate/fast/fast_sm.h"
#include "grtx/rtl_tlm/gpu/gpu_counters.h"

namespace grtx::sim::fast {

class Machine {
 public:
  /// stride: one in so many of a lane's events takes time, a power of two.
  Machine(const GpuConfig& config, const traces::Header& header, std::uint64_t eviction_entries,
          modules::GroupSource& source, unsigned stride);

  void observe(modules::WarpObserver* observer) { observer_ = observer; }
  void assign(std::vector<unsigned> sms) { assigned_ = std::move(sms); }
  void run(const std::function<void(std::uint64_t)>& progress);
  GpuCounters counters() const;
  bool idle() const;
  std::uint64_t steps() const { return wheel_.steps(); }

 private:
  static constexpr Cycle kAhead = 24;  ///< the L1 serves requests so many cycles ahead of time: many in one event

  enum class Taken : std::uint8_t { refused, hit, miss };

  Number lane_number(unsigned sm, unsigned entry, unsigned lane) const {
    return (sm * entries_ + entry) * modules::kMaxLanes + lane;
  }
  Number warp_number(unsigned sm, unsigned slot) const { return warps_from_ + sm * config_.resident_warps + slot; }
  static LaneMask lane_bit(Number number) { return modules::bit(number % modules::kMaxLanes); }
  void handle_event(Number number);
  /// A cycle of the run, in which all events take time, for one of what is simulated.
  Cycle whole(Cycle cycle) const { return cycle * stride_; }
  /// Nothing will be asked for before cycle `now` any more.
  void advance(Cycle now);
  [[noreturn]] void refuse(Number lane, const char* rule) const;

  // ---- Work distributor
  void launch(Cycle now);
  bool held_back(Cycle now);
  void ended(Cycle now, unsigned s, unsigned slot);

  // ---- SIMT core (fast_shader.cpp)
  void start(Cycle now, unsigned s, unsigned slot, Step step);
  void load(Cycle now, unsigned s, unsigned slot);
  void issue(Cycle now, unsigned s, unsigned slot);
  void store(Cycle now, unsigned s, unsigned slot);
  void warp_event(Cycle now, unsigned s, unsigned slot);
  void service_ends(Cycle now, unsigned s, unsigned slot);
  void enter(Cycle now, Sm& sm, Warp& warp, modules::WarpActivity activity);
  /// When the phase has what it loads, of which the last is there in cycle `seen`.
  Cycle loaded(const Warp& warp, Cycle seen);
  /// Consecutive sectors of a line and region are one request.
  template <typename F>
  void for_each_line(const std::vector<modules::SectorAccess>& sectors, F&& f) const;

  // ---- RT unit: calls and lanes (fast_rt_unit.cpp)
  void accept(Cycle now, unsigned s);
  void retire(Cycle now, unsigned s, unsigned entry);
  const traces::RayGroup& group_of(const Lane& lane) const {
    const Sm& sm = sms_[lane.sm];
    return *sm.warps[sm.calls[lane.entry].slot].group;
  }
  void count_wait(Cycle now, Sm& sm, Call& call);
  void count_stall(Cycle until, Sm& sm);
  void make_ready(Cycle now, Number number, const Lane& lane, Sm& sm, Call& call);
  /// From when on the memory scheduler's queue has room for any warp's visits; kNever: that is not known yet.
  Cycle room_from(Cycle now, Sm& sm) const;
  void select_soon(Cycle now, unsigned s, Sm& sm);
  void select(Cycle now, unsigned s);
  void handle(Cycle now, Number number, Lane& lane, Sm& sm, Call& call);
  void replay(Cycle now, Number number, Lane& lane, Sm& sm, Call& call);
  void lane_event(Cycle now, Number number, Lane& lane);
  /// What the lane's event does to its stack.
  void move_stack(Number number, Lane& lane, const modules::EventEffect& effect, Sm& sm) {
    if (!effect.move_stack(lane.depth)) refuse(number, modules::kRuleNodeOnStack);
    std::uint64_t& deepest = sm.rt.warp_buffer.max_stack_depth;
    if (effect.pushed() != 0) deepest = std::max<std::uint64_t>(deepest, lane.depth);
  }
  void complete(Cycle now, Number number, Lane& lane, const modules::EventEffect& effect, Sm& sm, Call& call);
  /// The lane's event has done all but write its checkpoint entries.
  void end_event(Cycle now, Number number, Lane& lane, unsigned checkpoints, Sm& sm, Call& call);
  void settled(Cycle now, Number number, Lane& lane, Sm& sm, Call& call);
  void any_hit_arrives(Cycle now, Number number, const Lane& lane, Sm& sm, Call& call);
  void consider_any_hit(Cycle now, unsigned s, unsigned entry);
  void fire(Cycle now, unsigned s, unsigned entry);

  // ---- Events that take no time (fast_warming.cpp)
  /// The lane's next `count` events, or those that are left, happen at once: caches, buffers and counts of the trace
  /// see them.
  void warm(Number number, Lane& lane, Sm& sm, Call& call, unsigned count);
  /// The lane's events up to the next that takes time. Returns whether there is one. apart: cycles since the warp was
  /// selected last.
  bool warm_up_to_next(Cycle now, Number number, Lane& lane, Sm& sm, Call& call, Cycle apart);
  /// Whether the event visits a node that its warp is fetching, and will be in cycle `then`.
  bool is_under_way(const traces::Event& event, const Sm& sm, const Call& call, Cycle now, Cycle then) const;
  void warm_any_hit(unsigned s, Sm& sm, const Call& call, Number number, const traces::Event& event);
  void warm_checkpoints(unsigned s, Sm& sm, Number number, unsigned entries, bool last);
  void warm_source(unsigned s, Sm& sm, Number number);
  void warm_siblings(unsigned s, Sm& sm, const traces::NodeDefinition& node, unsigned siblings);
  void warm_run(unsigned s, Sm& sm, Client client, const modules::SectorRun& run);
  void warm_line(unsigned s, Sm& sm, Client client, const modules::SectorAccess& sector, bool write) {
    warm_line(s, sm, client, sm.tags.line_address(sector.address), sm.tags.sector_bit(sector.address), sector.region,
              write);
  }
  void warm_line(unsigned s, Sm& sm, Client client, std::uint64_t line, std::uint8_t sectors, modules::Region region,
                 bool write) {
    Port& port = sm.ports[client];
    if (port.queue.empty()) return warm_caches(s, sm, client, line, sectors, region, write);
    port.queue.push({line, kNobody, sectors, region, write, false});  // not before those that came earlier
    ++port.timeless;
  }
  void warm_caches(unsigned s, Sm& sm, Client client, std::uint64_t line, std::uint8_t sectors, modules::Region region,
                   bool write);
  /// Runs the any-hit shader's program.
  void any_hit(Sm& sm, const modules::AnyHitBatch& batch, AnyHitWork& counted);
  std::uint64_t draw() {
    drawn_ = drawn_ * 6364136223846793005u + 1442695040888963407u;  // Knuth's MMIX
    return drawn_ >> 33;
  }
  /// Whether a line's requests take time: one in so many lines, others for each key.
  bool chosen(std::uint64_t line, std::uint64_t key) const {
    return stride_ == 1 || ((line ^ key << 33) * 0x9E3779B97F4A7C15u >> 40) % stride_ == 0;
  }

  // ---- RT unit: node fetches (fast_fetch.cpp)
  /// Counts the event, which visits a node, and refuses one that is not there.
  modules::NodeVisit visit(Number number, const traces::Event& event, Sm& sm, const Call& call);
  void fetch(Cycle now, Number number, Lane& lane, Sm& sm, Call& call, const modules::NodeVisit& node);
  void push_run(Sm& sm, Client client, Number owner, const modules::SectorRun& run, bool last);
  /// f(line, mask of sectors) for consecutive sectors, at most `most` of them at a time.
  template <typename F>
  static void for_each_part(const Sm& sm, std::uint64_t address, unsigned sectors, unsigned most, F&& f) {
    for (;;) {
      const std::uint64_t line = sm.tags.line_address(address);
      const auto first = static_cast<unsigned>((address - line) / modules::kSectorBytes);
      const unsigned count = std::min({sectors, sm.sectors - first, most});
      sectors -= count;
      f(line, static_cast<std::uint8_t>(((1u << count) - 1) << first));
      if (sectors == 0) return;
      address += std::uint64_t{count} * modules::kSectorBytes;
    }
  }
  /// The node is there in cycle `ready`.
  void await(Sm& sm, Number number, const Lane& lane, Cycle ready);
  void prefetch_siblings(Cycle now, const Lane& lane, Sm& sm, const modules::Siblings& siblings);
  void prefetch(Sm& sm, traces::NodeKind kind, std::uint64_t address);

  // ---- RT unit: checkpoints (fast_checkpoints.cpp)
  void begin_checkpoints(unsigned s, unsigned slot, unsigned i, std::uint32_t round, Number number, bool replay);
  void push_sector(Cycle now, Number number, std::uint64_t sector, bool write, bool last);
  /// The lane's next entry goes to its destination buffer.
  modules::CheckpointLayout::Sectors add_entry(Number number);
  /// The next entry of the lane's source buffer.
  modules::CheckpointLayout::Sectors take_source(Number number);
  /// Returns when all has been handed over.
  Cycle write_checkpoints(Cycle now, Number number, unsigned entries, bool last);
  /// Whether the entry is there already; else the lane waits.
  bool read_checkpoint(Cycle now, Number number);

  // ---- L1 (fast_l1.cpp)
  void serve(Cycle now, unsigned s);
  /// Returns whether the last request that was served was a miss.
  template <Client kClient>
  bool serve_port(Cycle now, unsigned s, Sm& sm);
  template <Client kClient>
  Taken try_head(Cycle now, unsigned s, Sm& sm);
  /// The cycle in which the banks take the last of the sectors, the first at `at` at the earliest.
  Cycle take_banks(Sm& sm, unsigned client, const Request& r, Cycle at);
  Cycle send_miss(unsigned s, Sm& sm, std::uint32_t filling, const Request& r, std::uint8_t missing, bool prefetched,
                  Cycle at);
  void fill(Cycle now, unsigned s, std::uint32_t number);
  /// Sectors of a line take their place in the tags.
  static modules::SectorCacheTags::Slot place(Sm& sm, std::uint64_t line, std::uint8_t sectors, bool timed);
  /// Sectors that a prefetch has brought are asked for.
  static void demand(Sm& sm, modules::SectorCacheTags::Slot slot, std::uint8_t sectors);
  /// The same of sectors on their way. awaited: of `sectors`, which have not arrived.
  static void demand(Sm& sm, Fill& fill, std::uint8_t sectors, std::uint8_t awaited);
  /// present: sectors in the tags or arrived. on_the_way: of those in sm.fills[filling]. The others of r are missed.
  template <Client kClient>
  static void count_access(Sm& sm, modules::SectorCacheTags::Slot slot, const Request& r, std::uint8_t present,
                           std::uint8_t on_the_way, std::uint32_t filling);
  template <Client kClient>
  void deliver(unsigned s, Sm& sm, const Request& r, Cycle seen);

  GpuConfig config_;
  const traces::Header& header_;
  modules::GroupSource& source_;
  modules::WarpObserver* observer_ = nullptr;
  std::vector<unsigned> assigned_;  ///< SMs of the first groups
  modules::NodeTraffic traffic_;
  modules::MemoryMap map_;
  bool one_by_one_;   ///< links to the L1 have one place, and carry something in every other cycle
  unsigned entries_;  ///< of a warp buffer
  std::vector<Lane> lanes_;
  Number warps_from_, timers_from_, ports_from_, selects_from_, fills_from_;
  Number fills_;  ///< of an SM
  EventWheel wheel_;
  FastMemory memory_;
  std::optional<modules::SiblingRecords> records_;  ///< with a sibling prefetcher
  modules::SiblingRequests requests_;
  std::optional<modules::CheckpointLayout> layout_;  ///< with checkpointing
  std::vector<Checkpoints> checkpoints_;
  std::vector<Sm> sms_;
  std::unique_ptr<modules::WarpSelection> selection_;
  unsigned stride_;
  std::uint64_t drawn_;                  ///< state of draw()
  std::uint64_t instructions_left_ = 0;  ///< of shortened phases, less than a whole one
  Cycle usual_wait_;                     ///< of a phase for its loads, a running mean, in 16ths of a cycle
  modules::ShaderPhase phase_;
  std::uint64_t next_age_ = 0;
  Cycle advanced_ = 0;  ///< when calendars were told of the time

  std::uint64_t next_group_ = 0, running_ = 0, ended_ = 0;
  const traces::RayGroup* acquired_ = nullptr;  ///< and not launched yet
  bool secondary_ = false;                      ///< primary groups are over
  unsigned turn_ = 0;                           ///< SM that is looked at first
  Cycle last_launch_ = 0;
  Cycle end_ = 0;          ///< when the last warp had ended
  Cycle primary_end_ = 0;  ///< the last primary one
  std::function<void(std::uint64_t)> progress_;
};

}  // namespace grtx::sim::fast
