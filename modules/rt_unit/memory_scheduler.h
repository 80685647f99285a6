// Memory scheduler of the RT unit: merges equal node addresses of a warp into one fetch and issues it by sectors.
// Paper: Section IV-B ("fetches the node at the top of the traversal stack"; duplicate requests are merged).
// Cost: a queue of fetches not fully issued, and one record of lanes and missing sectors for each lane of the warp
// buffer.
#pragma once

#include <array>
#include <cstdint>
#include <iosfwd>
#include <systemc>
#include <vector>

#include "grtx/modules/kernel/address_index.h"
#include "grtx/modules/kernel/bounded_queue.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/kernel/statistics.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/messages/node_fetch_messages.h"
#include "grtx/modules/rt_unit/node_traffic.h"

namespace grtx::modules {

class MemoryScheduler final : public sc_core::sc_module {
 public:
  struct Config {
    unsigned queue = 64;          ///< fetches waiting for issue, >= 32; a warp is scheduled while 32 places are free
    bool merge_in_flight = true;  ///< a visit also joins a fetch of the same warp and address that is still under way
    bool by_shader = false;       ///< the SIMT core reads the nodes; the RT unit only intersects (as on AMD)
    NodeTrafficConfig traffic;
  };
  struct Counters {
    std::array<std::uint64_t, kRegionCount> visits{};   ///< lane visits
    std::array<std::uint64_t, kRegionCount> fetches{};  ///< after merging
    std::array<std::uint64_t, kRegionCount> sectors{};  ///< requests sent
    std::uint64_t shader_batches = 0;                   ///< by_shader: messages to the SIMT core
    std::uint64_t shader_sectors = 0;                   ///< by_shader: sectors asked of it, all of `sectors`
    Distribution fetch_latency;                         ///< cycles from the first lane's visit to the last sector
    std::uint64_t node_visits() const;
    std::uint64_t node_fetches() const;
    std::uint64_t node_sectors() const;
    void add(const Counters& other);
    void describe(StatisticList& list, const std::string& prefix) const;
  };
  /// A fetch whose sectors are all back.
  struct Completed {
    unsigned entry = 0;
    LaneMask lanes = 0;  ///< 0: the response did not complete a fetch
    traces::NodeKind kind = traces::NodeKind::internal;
  };

  MemoryScheduler(const sc_core::sc_module_name& name, const Config& config, const traces::Header& header,
                  unsigned entries);

  const NodeTraffic& traffic() const { return traffic_; }
  /// Whether any warp's visits are sure to fit.
  bool has_room() const { return queue_.room() >= kMaxLanes; }
  /// Starts the visits of one warp in one cycle: only visits between two calls merge (and those in flight, if asked).
  void begin_warp(Cycle now, unsigned entry);
  /// Lane `id` of the warp visits the node at `address` (bytes). header: the BLAS header is read as well.
  void visit(LaneId id, traces::NodeKind kind, std::uint64_t address, bool header);

  /// Sends at most one sector. Returns whether it did.
  bool issue(Cycle now, LinkWriter<MemoryRequest>& out) { return !queue_.empty() && issue_front(now, out); }
  /// Takes at most one response.
  Completed respond(Cycle now, LinkReader<MemoryResponse>& in) {
    const MemoryResponse* response = in.front(now);
    if (response == nullptr) return {};
    const auto fetch = static_cast<LaneId>(response->tag);
    in.pop(now);
    return receive(now, fetch);
  }

  /// by_shader, instead of issue(): sends the fetches at the front of the queue that belong to one warp. Returns
  /// whether it did. slot_of(entry): resident slot of the warp in a buffer entry.
  template <typename SlotOf>
  bool issue_batch(Cycle now, LinkWriter<NodeFetchBatch>& out, SlotOf&& slot_of) {
    if (queue_.empty() || !out.can_push(now)) return false;
    const unsigned entry = entry_of(queue_.front().fetch);
    out.push(now, take_batch(entry, slot_of(entry)));
    return true;
  }
  /// by_shader, instead of respond(): takes at most one batch that the SIMT core has read; f(completed) for each fetch,
  /// by the lane that opened it.
  template <typename F>
  void respond_batch(Cycle now, LinkReader<NodeFetchDone>& in, F&& f) {
    const NodeFetchDone* front = in.front(now);
    if (front == nullptr) return;
    const NodeFetchDone done = *front;
    in.pop(now);
    for_each_bit(done.fetches, [&](unsigned lane) {
      const LaneId id = lane_id(done.entry, lane);
      outstanding_ -= fetches_[id].missing;
      fetches_[id].missing = 0;
      f(complete(now, id));
    });
  }

  bool queue_empty() const { return queue_.empty(); }
  std::size_t queued() const { return queue_.size(); }        ///< fetches not fully issued
  std::uint64_t outstanding() const { return outstanding_; }  ///< sectors sent, not answered
  bool idle() const { return queue_.empty() && outstanding_ == 0; }
  const Counters& counters() const { return counters_; }
  Inventory inventory() const;
  void dump_state(std::ostream& out) const;

 private:
  struct Fetch {
    std::uint64_t address = 0;
    LaneMask lanes = 0;
    Cycle asked = 0;
    traces::NodeKind kind = traces::NodeKind::internal;
    bool header = false;
    std::uint8_t sectors = 0;  ///< to send
    std::uint8_t missing = 0;  ///< responses not yet back
  };
  struct Pending {
    LaneId fetch = 0;
    std::uint8_t next = 0;  ///< sector to send next
  };
  static std::uint64_t merge_key(std::uint64_t address, bool header);
  bool issue_front(Cycle now, LinkWriter<MemoryRequest>& out);
  Completed receive(Cycle now, LaneId fetch);
  Completed complete(Cycle now, LaneId fetch);
  SectorAccess sector_of(const Fetch& fetch, unsigned index) const;
  NodeFetchBatch take_batch(unsigned entry, std::uint16_t slot);

  Config config_;
  NodeTraffic traffic_;
  std::vector<Fetch> fetches_;       ///< by the lane that asked first: a lane has at most one visit under way
  std::vector<LaneMask> under_way_;  ///< by entry: lanes that lead a fetch
  BoundedQueue<Pending> queue_;
  std::vector<AddressIndex> merge_;     ///< by entry: finds the fetch, by leading lane, that a visit may join
  std::vector<std::uint64_t> visited_;  ///< without merging in flight: keys of the present warp's visits
  unsigned visited_entry_ = 0;
  Cycle now_ = 0;
  std::uint64_t outstanding_ = 0;  ///< sectors sent, not answered
  Counters counters_;
};

}  // namespace grtx::modules
