// The L1 of an SM in fast mode: its five clients take turns, and a request learns at once when it is answered. What is
// on its way stands beside the tags, with the cycle of its arrival, and takes its place in them when it has come.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

#include "grtx/modules/cache/decide/sector_cache_tags.h"
#include "grtx/modules/cache/l1_cache.h"
#include "grtx/modules/kernel/address_index.h"
#include "grtx/modules/kernel/ring_queue.h"
#include "grtx/modules/messages/coalescer.h"
#include "grtx/modules/rt_unit/decide/node_visit.h"
#include "grtx/rtl_tlm/estimate/fast/bank_calendar.h"
#include "grtx/rtl_tlm/estimate/fast/near_cycle.h"
#include "grtx/rtl_tlm/estimate/fast/place_calendar.h"
#include "grtx/rtl_tlm/estimate/fast/place_ring.h"
#include "grtx/rtl_tlm/estimate/fast/response_calendar.h"
#include "grtx/rtl_tlm/estimate/fast/shared.h"

namespace grtx::sim::fast {

class RtUnit;
class Simt;

/// Clients of the L1, in the cycle model's order.
enum Client : unsigned { kNode, kSimt, kCheckpoint, kPrefetch, kStack, kClients };

inline constexpr std::uint32_t kNobody = ~std::uint32_t{0};

/// Sectors of one line, which an L1 client asks for.
struct Request {
  std::uint64_t line = 0;   ///< address
  std::uint32_t owner = 0;  ///< lane, or warp slot; kNobody: an access that takes no time, behind those that do
  std::uint8_t sectors = 0;
  modules::Region region{};
  bool write = false;
  bool last = false;  ///< of a node fetch, or of what a lane reads of a checkpoint buffer or of its stack
};
static_assert(sizeof(Request) == 16);

class L1 {
 public:
  L1(Shared& shared, unsigned sm);
  L1(const L1&) = delete;
  void connect(RtUnit& rt, Simt& simt) {
    rt_ = &rt;
    simt_ = &simt;
  }
  static std::size_t fills_of(const GpuConfig& config);  ///< lines that may be on their way into the L1

  // ---- Clients
  /// Puts a request into the client's port; serve() takes it from there.
  void push(Client client, const Request& request) {
    ports_[client].queue.push(request);
    waiting_ |= 1u << client;
  }
  /// The same for consecutive sectors.
  void push(Client client, std::uint32_t owner, const modules::SectorRun& run, bool write, bool last) {
    unsigned sectors = run.sectors;
    for_each_line(run, largest_, [&](std::uint64_t line, std::uint8_t mask) {
      sectors -= static_cast<unsigned>(std::popcount(mask));
      push(client, {line, owner, mask, run.region, write, last && sectors == 0});
    });
  }
  bool idle(Client client) const { return ports_[client].queue.empty(); }
  std::size_t queued(Client client) const { return ports_[client].queue.size(); }
  std::size_t timed(Client client) const { return ports_[client].timed(); }  ///< of these, requests that take time
  /// Whether a request for the sector at `address` waits that takes time.
  bool waits(Client client, std::uint64_t address) const;
  /// The client sends nothing before cycle `from`.
  void hold(Client client, Cycle from) { ports_[client].next = std::max(ports_[client].next, from); }
  /// Serves all ports as far as they can be now.
  void serve(Cycle now);

  // ---- Accesses that take no time (docs/model/fast-mode.md): they change the tags, behind what waits in the port
  void warm(Client client, const modules::SectorAccess& sector, bool write) {
    warm(client, tags_.line_address(sector.address), tags_.sector_bit(sector.address), sector.region, write);
  }
  void warm(Client client, const modules::SectorRun& run) {
    for_each_line(run, sectors_,
                  [&](std::uint64_t line, std::uint8_t mask) { warm(client, line, mask, run.region, false); });
  }
  void warm(Client client, std::uint64_t line, std::uint8_t sectors, modules::Region region, bool write) {
    Port& port = ports_[client];
    if (port.queue.empty()) return warm_caches(client, line, sectors, region, write);
    port.queue.push({line, kNobody, sectors, region, write, false});  // not before those that came earlier
    ++port.timeless;
  }

  /// Before the first request: lines are those that `before` has left, which loses them.
  void keep(L1& before) {
    tags_ = std::move(before.tags_);
    tags_.restart(true);
    written_by_ = std::move(before.written_by_);
  }
  /// What keep() takes over.
  void save(StateWriter& state) const {
    tags_.save(state);
    modules::save_regions(written_by_, state);
  }
  void load(StateReader& state) {
    tags_.load(state);
    modules::load_regions(written_by_, state);
  }

  // ---- Events
  void turn(Cycle now) {
    turn_timed_ = false;
    serve(now);
  }
  void fill(Cycle now, std::uint32_t number);
  void advance(Cycle now) {
    responses_.advance(now * ports_[kNode].width);
    banks_.advance(now);
  }

  const modules::SectorCacheTags& tags() const { return tags_; }
  unsigned sectors() const { return sectors_; }  ///< of a line
  unsigned largest() const { return largest_; }  ///< sectors of a request
  /// f(line, mask of sectors) for the lines of a run, at most `most` sectors at a time.
  template <typename F>
  void for_each_line(const modules::SectorRun& run, unsigned most, F&& f) const {
    std::uint64_t address = run.address;
    unsigned sectors = run.sectors;
    for (;;) {
      const std::uint64_t line = tags_.line_address(address);
      const auto first = static_cast<unsigned>((address - line) / modules::kSectorBytes);
      const unsigned count = std::min({sectors, sectors_ - first, most});
      sectors -= count;
      f(line, static_cast<std::uint8_t>(((1u << count) - 1) << first));
      if (sectors == 0) return;
      address += std::uint64_t{count} * modules::kSectorBytes;
    }
  }
  bool idle() const;
  modules::L1Counters counters() const;

 private:
  static constexpr unsigned kNodesWin = 8;  ///< of so many conflicts with their wide port they win one; measured
  static constexpr Cycle kAhead = 24;       ///< requests are served so many cycles ahead of time: many in one event

  /// A client's port: `width` sectors a cycle.
  struct Port {
    modules::RingQueue<Request> queue;
    std::size_t timeless = 0;  ///< requests of kNobody in it
    std::size_t timed() const { return queue.size() - timeless; }
    unsigned width = 1;
    Cycle next = 0;           ///< free from
    unsigned used = 0;        ///< sectors taken in that cycle, of a wide port
    std::uint64_t banks = 0;  ///< where they lie
    void begin_cycle() { used = 0, banks = 0; }
    Cycle until = 0;  ///< refused until
  };
  /// Sectors of a line on their way into the L1. They take the line's place in the tags when all are there.
  struct Fill {
    std::uint64_t line = 0;       ///< address
    std::uint8_t sectors = 0;     ///< mask
    std::uint8_t prefetched = 0;  ///< of these, which nobody has asked for
    std::array<NearCycle, 8> arrives;
    Cycle complete = 0;

    /// Those of `wanted` that come after cycle `now`; last: raised to the arrival of the last of them.
    std::uint8_t awaited(std::uint8_t wanted, Cycle now, Cycle& last) const;
  };
  enum class Taken : std::uint8_t { refused, hit, miss };

  /// Returns whether the last request that was served was a miss.
  template <Client kClient>
  bool serve_port(Cycle now);
  template <Client kClient>
  Taken try_head(Cycle now);
  /// The cycle in which the banks take the last of the sectors, the first at `at` at the earliest.
  Cycle take_banks(unsigned client, const Request& r, Cycle at);
  /// When the RT unit has the answers to a node request that went through in cycle `taken` and are due up to `seen`.
  Cycle return_nodes(unsigned count, Cycle taken, Cycle seen, bool in_pipeline);
  Cycle send_miss(std::uint32_t filling, const Request& r, std::uint8_t missing, bool prefetched, Cycle at);
  /// Sectors of a line, of which a prefetch has brought these, take their place in the tags in cycle `now`, unless
  /// nothing in their set can leave.
  void place(std::uint64_t line, std::uint8_t sectors, std::uint8_t prefetched, Cycle now);
  /// Whether the write-back buffer has room in cycle `at` for what `line` would replace, if that needs it.
  bool victim_can_leave(std::uint64_t line, Cycle at) const {
    return leaving_.room() <= at || tags_.victim(line).dirty == 0;
  }
  /// A line of the tags for `line`, which has none; what it held is written back, at `now` or at no time.
  modules::SectorCacheTags::Slot allocate(std::uint64_t line, Cycle now, bool timed) {
    return allocate(line, tags_.victim_slot(line), now, timed);
  }
  modules::SectorCacheTags::Slot allocate(std::uint64_t line, modules::SectorCacheTags::Slot place, Cycle now,
                                          bool timed);
  /// A write's sectors that stay here. slot: of their line, if it is present.
  void keep_write(modules::SectorCacheTags::Slot slot, std::uint64_t line, std::uint8_t sectors, modules::Region region,
                  bool dirty, Cycle now, bool timed);
  /// Sectors that a prefetch has brought are asked for.
  void demand(modules::SectorCacheTags::Slot slot, std::uint8_t sectors);
  /// The same of sectors on their way. awaited: of `sectors`, which have not arrived.
  void demand(Fill& fill, std::uint8_t sectors, std::uint8_t awaited);
  /// present: sectors in the tags or arrived. on_the_way: of those in fills_[filling]. The others of r are missed.
  template <Client kClient>
  void count_access(modules::SectorCacheTags::Slot slot, const Request& r, std::uint8_t present,
                    std::uint8_t on_the_way, std::uint32_t filling);
  template <Client kClient>
  void deliver(const Request& r, Cycle seen);
  void warm_caches(Client client, std::uint64_t line, std::uint8_t sectors, modules::Region region, bool write);

  Shared& shared_;
  const modules::L1Cache::Config& config_;
  unsigned sm_;
  RtUnit* rt_ = nullptr;
  Simt* simt_ = nullptr;
  bool one_by_one_;  ///< links to the L1 have one place, and carry something in every other cycle
  modules::SectorCacheTags tags_;
  std::vector<modules::Region> written_by_;  ///< by line of the tags: of its dirty sectors
  unsigned sectors_, largest_;
  std::vector<Fill> fills_;
  std::vector<std::uint32_t> free_fills_;
  modules::AddressIndex filling_;  ///< fills by line
  PlaceRing link_;                 ///< to the L1, for node requests
  Cycle link_pushed_ = 0;          ///< when the newest entered it
  PlaceRing crossed_;              ///< miss queue and the link behind it
  PlaceRing leaving_;              ///< write-back buffer
  PlaceCalendar mshrs_;
  PlaceRing hits_;  ///< pipeline
  BankCalendar banks_;
  bool between_ = false;        ///< the next bank conflict is the node request's
  unsigned conflict_ = 0;       ///< number of the last one with a wide port of nodes
  ResponseCalendar responses_;  ///< to node requests; a cycle has as many places as their port is wide
  std::array<Port, kClients> ports_;
  unsigned waiting_ = 0;     ///< bits of the ports with requests
  unsigned first_ = 0;       ///< whose turn it is
  bool turn_timed_ = false;  ///< the next turn is on the agenda
  modules::L1Counters counters_;
};

}  // namespace grtx::sim::fast
