// SPDX-License-Identifier: Apache-2.0
// The L1 data cache as an SM sees it: its ports, its configuration, its counters, and how to make one (l1_cache.h).
#pragma once

#include <array>
#include <cstdint>
#include <iosfwd>
#include <memory>
#include <string>
#include <systemc>
#include <vector>

#include "grtx/base/state_bytes.h"
#include "grtx/modules/cache/cache_counters.h"
#include "grtx/modules/cache/decide/cache_geometry.h"
#include "grtx/modules/cache/decide/write_policy.h"
#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

struct L1Counters;

/// An L1 as the SM sees it: every request gets exactly one response with its tag, in any order. An implementation that
/// needs no clock may ignore it.
class L1CacheModule : public ClockedModule {
 public:
  sc_core::sc_vector<LinkIn<MemoryRequest>> request;     ///< [client], consumed here
  sc_core::sc_vector<LinkOut<MemoryResponse>> response;  ///< [client], produced here
  LinkOut<MemoryRequest> to_memory{"to_memory"};         ///< misses and writes, with client and SM filled in
  LinkIn<MemoryResponse> from_memory{"from_memory"};     ///< fills and write acknowledgements

  /// Counts so far.
  virtual L1Counters counters() const = 0;
  /// Nothing inside and nothing waiting at its ports.
  virtual bool idle() const = 0;
  virtual Inventory inventory() const = 0;
  virtual void dump_state(std::ostream& out) const = 0;
  /// Makes the sector present as one read before, without traffic and uncounted, in place of a clean line if there is
  /// one. A cache that ignores it is colder than the run it stands for.
  virtual void preload(std::uint64_t /*address*/) {}
  /// Save and restore what restart(Caches::warm) keeps, for a run that another process continues. save() needs an idle
  /// cache, load() a newly constructed one.
  virtual void save(StateWriter& state) const;
  virtual void load(StateReader& state);

 protected:
  L1CacheModule(const char* name, ClockDomain& clock, unsigned clients) = delete;  ///< see ClockedModule
  L1CacheModule(const sc_core::sc_module_name& name, ClockDomain& clock, unsigned clients)
      : ClockedModule(name, clock), request("request", clients), response("response", clients) {}
};

/// Why the request at the head of a client's port was not accepted in this cycle.
enum class L1Stall : std::uint8_t { response_port, bank_conflict, mshr_full, merges_full, miss_queue_full };
constexpr auto enum_names(L1Stall) {
  return names_in_order<L1Stall>({"response_port", "bank_conflict", "mshr_full", "merges_full", "miss_queue_full"});
}

/// Counters of one cache; the GPU sums them over its SMs. Demand and prefetch accesses are counted separately.
struct L1Counters : CacheRegions {
  std::array<std::uint64_t, kCountOf<L1Stall>> stalls{};  ///< client-cycles
  /// prefetches = redundant + fetched; fetched = useful + late + unused, once nothing is pending.
  std::uint64_t prefetches = 0, prefetches_redundant = 0, prefetches_fetched = 0;
  std::uint64_t prefetches_useful = 0, prefetches_late = 0, prefetches_unused = 0;
  std::uint64_t responses = 0, fills = 0, fills_bypassed = 0, evictions = 0;
  std::uint64_t kept_writes = 0, rewrites = 0, write_backs = 0;
  std::uint64_t sent_reads = 0, sent_writes = 0;  ///< to the crossbar
  std::uint64_t mshr_cycles = 0;
  Distribution miss_latency;  ///< from MSHR allocation to fill, core cycles
  OwnCounts own;              ///< extra counters of a user-supplied cache

  /// Demand and prefetch requests accepted.
  std::uint64_t accesses() const;
  static const CounterTable<L1Counters>& table();
  L1Counters& operator+=(const L1Counters& other) {
    table().add(*this, other);
    return *this;
  }
  /// Appends them as prefix + ".name".
  void describe(StatisticList& list, const std::string& prefix) const { table().describe(*this, list, prefix); }
};

struct L1CacheConfig {
  unsigned clients = 2;          ///< request/response port pairs; set by the assembly
  std::uint8_t sm = 0;           ///< SM number that requests carry into the crossbar; set by the assembly
  std::vector<unsigned> widths;  ///< [client] port width in sectors per cycle, 1 if absent; set by the assembly
  CacheGeometry geometry{};
  unsigned latency = 20;
  unsigned tag_latency = 1;
  unsigned banks = 4;
  unsigned mshr_entries = 256;
  unsigned mshr_merges = 8;
  unsigned miss_queue = 16;
  PrivateWrites private_writes;
  unsigned write_back_buffer = 16;  ///< lines; unused unless private_writes is write_back
  bool rotating_priority = true;    ///< start after the client that last won first; false: always start at client 0
  bool perfect = false;             ///< every access hits; nothing is sent to the L2
  void parameters(ParameterList& list) {
    list.add("bytes", geometry.bytes, {32, 1 << 26}, "B", "size of the L1 data cache", kTable1);
    geometry.shape_parameters(list);
    list.add("latency", latency, {1, kMaxLatency}, "cycles", "from request to response of a hit", kTable1);
    list.add("tag_latency", tag_latency, {1, kMaxLatency}, "cycles", "from request to a miss leaving the cache", kOurs);
    list.add("banks", banks, {1, 64}, "banks", "sector-interleaved banks, each with one access per cycle", kVulkanSim);
    list.add("mshr_entries", mshr_entries, {1, kMaxEntries}, "sectors", "sectors outstanding", kVulkanSim);
    list.add("mshr_merges", mshr_merges, {1, kMaxEntries}, "requests", "requests of an MSHR, the first included",
             kVulkanSim);
    list.add("miss_queue", miss_queue, {1, kMaxEntries}, "requests", "misses and writes waiting for the crossbar",
             kVulkanSim);
    private_writes.parameters(list);
    list.add("write_back_buffer", write_back_buffer, {1, kMaxEntries}, "lines",
             "dirty lines that have left and wait for the crossbar; with private_writes = write_back",
             from_public("XiangShan: 18 entries of a line beside 16 misses"));
    list.add("rotating_priority", rotating_priority, "rotating priority of the clients; else node fetches first",
             kOurs);
    list.add("perfect", perfect, "every access hits (limit study)", kOurs);
    list.rule(
        "bytes", [this] { return geometry.sets() >= 1; }, "must hold at least l1.ways lines of l1.line_bytes");
  }
};

/// The project's L1. clock: core domain. Throws Error for an impossible configuration.
std::unique_ptr<L1CacheModule> make_l1_cache(const sc_core::sc_module_name& name, const L1CacheConfig& config,
                                             ClockDomain& clock);

}  // namespace grtx::modules
