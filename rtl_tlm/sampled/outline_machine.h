// The machine of the outline model: its parts, and the class that runs them. One number in the event wheel stands for
// each lane, each resident warp, each warp buffer entry's any-hit timer, and each SM's L1 port and warp scheduler.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "modules/lane_loop.h"
#include "modules/memory_map.h"
#include "modules/node_traffic.h"
#include "modules/ring_queue.h"
#include "modules/round_cursor.h"
#include "modules/shader_program.h"
#include "modules/warp_selection.h"
#include "rtl_tlm/sampled/event_wheel.h"
#include "rtl_tlm/sampled/outline_memory.h"
#include "rtl_tlm/sampled/outline_model.h"

namespace grtx::tlm::outline {

using modules::bit;
using modules::for_each_bit;
using modules::kMaxLanes;
using modules::kNever;
using modules::kSectorBytes;
using modules::RingQueue;
using modules::SectorAccess;
using modules::SectorCacheTags;
using traces::Event;
using traces::EventKind;
using traces::NodeKind;
using Number = EventWheel::Number;

// Requests are served so many cycles ahead of time: many in one event.
constexpr Cycle kAhead = 24;
constexpr std::uint8_t kNoPlace = 255;

enum Client : unsigned { kNode, kSimt, kCheckpoint, kPrefetch, kClients };

/// Sectors of one line.
struct Request {
  std::uint64_t line = 0;
  Number owner = 0;  ///< lane, or warp
  std::uint8_t sectors = 0;
  std::uint8_t place = kNoPlace;
  bool write = false;
  bool last = false;
};

struct Port {
  RingQueue<Request> queue;
  Cycle next = 0;   ///< free from
  Cycle until = 0;  ///< refused until
};

/// A node on its way to a warp.
struct Fetch {
  std::uint64_t key = ~std::uint64_t{0};
  Cycle ready = 0;
  LaneMask lanes = 0;
};
constexpr std::size_t kPlaces = 64;
constexpr unsigned kProbes = 4;

enum class Taken : std::uint8_t { refused, hit, miss };

struct Lane {
  const Event* next = nullptr;
  const Event* end = nullptr;
  Cycle seen = 0;
  std::uint16_t sm = 0, entry = 0;
};

/// An internal visit whose hit children may be prefetched.
struct Record {
  std::uint32_t begin = 0, end = 0, definition = 0;
  std::uint8_t hit = 0;
  bool armed = false;
};

struct Checkpoints {
  std::uint64_t source = 0, destination = 0, held = ~std::uint64_t{0};
  std::uint32_t source_entries = 0, read = 0, written = 0;
};

struct Call {
  std::uint16_t slot = 0;
  LaneMask active = 0, ready = 0, waiting = 0, in_shader = 0;
  Cycle since = 0;
  bool timing = false;  ///< its timer is in the wheel
  std::array<Fetch, kPlaces> fetches{};
};

enum class Step : std::uint8_t { prologue, evict_move, trace_call, tracing, sort, blend, epilogue, draining };

struct Warp {
  traces::RayGroup group;
  modules::RoundCursor cursor;
  std::size_t position = 0;
  Step step = Step::prologue;
  bool in_service = false;
  LaneMask service_lanes = 0;
  unsigned entry = 0;
  std::uint64_t instructions = 0;
  std::vector<SectorAccess> stores;
  std::uint32_t loads_pending = 0, stores_pending = 0;
  Cycle loads_seen = 0, stores_seen = 0;
};

struct Sm {
  Sm(const GpuConfig& config, const traces::Header& header, const modules::MemoryMap& map, unsigned index)
      : program(header, map, config.simt.costs, index, config.resident_warps),
        tags(config.l1.geometry),
        arrives(tags.geometry().bytes / config.l1.geometry.sector_bytes),
        line_arrives(tags.geometry().bytes / config.l1.geometry.line_bytes),
        sectors(config.l1.geometry.sectors()),
        crossed(config.l1.miss_queue + config.links.capacity),
        mshrs(config.l1.mshr_entries),
        hits(config.l1.latency) {}
  modules::ShaderProgram program;
  SectorCacheTags tags;
  std::vector<Cycle> arrives;       ///< by line and sector
  std::vector<Cycle> line_arrives;  ///< the last of its sectors
  unsigned sectors;                 ///< of a line
  PlaceRing crossed, mshrs, hits;
  PortCalendar responses;  ///< to node requests, one a cycle
  unsigned conflicts = 0;
  std::array<Port, kClients> ports;
  unsigned first = 0;
  bool port_timed = false;
  std::vector<Call> calls;
  std::vector<Warp> warps;
  RingQueue<std::uint16_t> waiting_calls;
  LaneMask free_slots = 0, free_entries = 0;
  LaneMask ready = 0;               ///< entries with lanes to be handled
  std::vector<std::uint64_t> ages;  ///< by entry
  std::size_t fetches = 0;          ///< nodes that wait for the L1
  bool select_timed = false;
};
class Machine {
 public:
  Machine(const traces::Reader& reader, const std::vector<std::uint64_t>& groups, const std::vector<Launch>& known,
          const GpuConfig& config, const std::function<void(const traces::RayGroup&)>& decoded);
  OutlineRun run();

 private:
  static LaneMask mask_of(unsigned bits) { return bits >= 64 ? ~LaneMask{0} : bit(bits) - 1; }
  Number lane_number(unsigned sm, unsigned entry, unsigned lane) const {
    return (sm * entries_ + entry) * kMaxLanes + lane;
  }
  // ---- launches
  void launch(Cycle now);
  void ended(Cycle now, unsigned s, unsigned slot);
  // ---- shader phases
  void start(Cycle now, unsigned s, unsigned slot, Step step);
  /// Consecutive sectors of a line are one request.
  template <typename F>
  void for_each_line(const std::vector<SectorAccess>& sectors, F&& f) {
    const SectorCacheTags& tags = sms_.front()->tags;
    for (std::size_t i = 0; i < sectors.size();) {
      const std::uint64_t line = tags.line_address(sectors[i].address);
      std::uint8_t mask = 0;
      for (; i < sectors.size() && tags.line_address(sectors[i].address) == line; ++i) {
        const std::uint8_t b = tags.sector_bit(sectors[i].address);
        if ((mask & b) != 0) break;
        mask |= b;
      }
      f(line, mask);
    }
  }
  void load(Cycle now, unsigned s, unsigned slot);
  void store(Cycle now, unsigned s, unsigned slot);
  void warp_event(Cycle now, Number number);
  // ---- RT unit
  void accept(Cycle now, unsigned s);
  void retire(Cycle now, unsigned s, unsigned entry);
  const traces::RayGroup& group_of(const Lane& lane) const {
    const Sm& sm = *sms_[lane.sm];
    return sm.warps[sm.calls[lane.entry].slot].group;
  }
  /// The next event of the lane waits for its warp's turn.
  void make_ready(Cycle now, Number number, const Lane& lane);
  bool has_room(const Sm& sm) const { return sm.fetches + kMaxLanes <= config_.rt.memory.queue; }
  void select_soon(Cycle now, unsigned s);
  /// One warp a cycle: all its lanes that are ready.
  void select(Cycle now, unsigned s);
  void handle(Cycle now, Number number, Lane& lane);
  void advance(Cycle now, Number number, Lane& lane, unsigned checkpoints);
  void tested(Cycle now, Number number, Lane& lane);
  bool returned(const Lane& lane) const { return lane.seen == kNever; }
  void returned_from_shader(Lane& lane, bool yes) { lane.seen = yes ? kNever : 0; }
  void consider_any_hit(Cycle now, unsigned s, unsigned entry);
  void timer_event(Cycle now, Number number);
  void fire(Cycle now, unsigned s, unsigned entry);
  // ---- node fetches
  void fetch(Cycle now, Number number, Lane& lane, NodeKind kind, std::uint64_t address, bool header);
  /// Asks the host for what serving a request will read.
  void prefetch_host(const Sm& sm, std::uint64_t address) const {
    sm.tags.prefetch(address);
    memory_.prefetch_host(sm.tags.line_address(address));
  }
  void push_node(Sm& sm, Client client, Number owner, std::uint64_t address, unsigned sectors, std::uint8_t place,
                 bool last);
  /// The node is there in cycle `ready`.
  void await(Number number, const Lane& lane, Cycle ready);
  Record* records_of(Number number) { return &records_[std::size_t{number} * config_.rt.prefetcher.records]; }
  void note_internal(Number number, const Lane& lane, const Event& event);
  void note_leaf(Number number, const Lane& lane, std::uint32_t address);
  // ---- checkpoints
  void begin_checkpoints(unsigned s, unsigned slot, unsigned i, std::uint32_t round, Number number, bool replay);
  void push_sector(Cycle now, Number number, std::uint64_t sector, bool write, bool last);
  void write_checkpoints(Cycle now, Number number, unsigned entries, bool last);
  /// Whether the entry is there already; else the lane waits.
  bool read_checkpoint(Cycle now, Number number);
  // ---- L1
  void serve(Cycle now, unsigned s);
  Taken try_head(Cycle now, unsigned s, Sm& sm, unsigned client);
  void deliver(unsigned s, Sm& sm, unsigned client, const Request& r, Cycle seen);
  const traces::Reader& reader_;
  const traces::Header& header_;
  const std::vector<std::uint64_t>& groups_;
  const std::vector<Launch>& known_;
  const GpuConfig& config_;
  const std::function<void(const traces::RayGroup&)>& decoded_;
  modules::NodeTraffic traffic_;
  modules::MemoryMap map_;
  unsigned entries_;
  std::vector<Lane> lanes_;
  Number warps_from_, timers_from_, ports_from_, selects_from_;
  EventWheel wheel_;
  OutlineMemory memory_;
  std::vector<Record> records_;       ///< so many of each lane as the prefetcher has
  std::vector<std::uint8_t> newest_;  ///< of a lane's records
  std::vector<Checkpoints> checkpoints_;
  std::vector<std::unique_ptr<Sm>> sms_;
  std::array<std::uint32_t, 8> units_{};
  unsigned leaf_latency_ = 0;
  std::unique_ptr<modules::WarpSelection> selection_;
  modules::ShaderPhase phase_;
  traces::RayGroup next_group_;
  bool ready_ = false, secondary_ = false;
  std::size_t next_ = 0, running_ = 0;
  std::uint64_t next_age_ = 0;
  unsigned turn_ = 0;
  Cycle last_launch_ = 0, end_ = 0, advanced_ = 0;
  OutlineRun result_;
};

}  // namespace grtx::tlm::outline
