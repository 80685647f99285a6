// The shared half of the memory in fast mode: crossbar delays, L2 slices and DRAM channels. Ports and buses are
// resources that a request reserves, one after the other, in the order of time; tags, MSHRs and the DRAM's command
// scheduler are those of the cycle model. Nothing blocks backwards: what the cycle model keeps in full queues waits
// here in longer ones.
#pragma once

#include <cstdint>
#include <vector>

#include "modules/dram.h"
#include "modules/dram_channel.h"
#include "modules/l2_slice.h"
#include "modules/memory_request.h"
#include "modules/mshr_table.h"
#include "modules/ring_queue.h"
#include "modules/sector_cache_tags.h"
#include "rtl_tlm/gpu_config.h"

namespace grtx::tlm {

class FastMemory {
 public:
  struct Reply {
    modules::MemoryResponse response;
    Cycle due = 0;  ///< visible at the SM
  };

  /// bytes: size of the memory.
  FastMemory(const GpuConfig& config, std::uint64_t bytes);

  /// A miss or write enters the crossbar's link in cycle `sent` (ascending for each SM).
  void send(const modules::MemoryRequest& request, Cycle sent);
  /// All requests sent before cycle `end` are known: finds the replies that are due before end + lookahead().
  void run(Cycle end);
  /// Cycles from the sending of a request to its earliest reply: through the crossbar, the slice's pipe and back.
  Cycle lookahead() const { return 2 * latency_ + pipe_; }
  /// Requests of the SM that were sent before the `end` of the last run() and had not crossed by then.
  std::size_t backlog(unsigned sm) const { return inputs_[sm].requests.size(); }
  /// To one SM, ascending due cycle; the SM takes them out.
  modules::RingQueue<Reply>& replies(unsigned sm) { return ports_[sm].replies; }
  /// run() with an `end` up to this cycle does nothing, unless requests are sent.
  Cycle next_due() const;
  bool idle() const;

  // Counts in the form of the cycle model's.
  const std::vector<modules::L2Counters>& slices() const { return l2_; }
  modules::DramCounters dram(Cycle end) const;
  std::vector<modules::DramChannelCounters> channels() const;
  std::uint64_t packets() const { return packets_; }  ///< through either network of the crossbar
  std::uint64_t dirty_sectors() const;

 private:
  static constexpr std::uint32_t kWriteBack = ~std::uint32_t{0};

  struct Arrival {
    modules::MemoryRequest request;
    Cycle at = 0;  ///< seen by the crossbar, or, in a slice's pipe, due at the tags
  };
  struct DramRequest {
    std::uint64_t address = 0;
    std::uint32_t context = 0;
    bool write = false;
    Cycle sent = 0;  ///< core cycle
  };
  struct Fill {
    std::uint32_t context = 0;
    std::uint64_t address = 0;
    Cycle due = 0;  ///< core cycle
  };
  /// An SM's input of the crossbar: only its oldest request can cross.
  struct Input {
    modules::RingQueue<Arrival> requests;
    Cycle free = 0;  ///< earliest crossing of the next one
  };
  struct Slice {
    Slice(const modules::L2Slice::Config& c, const modules::DramChannelConfig& channel)
        : config(c), tags(c.geometry), mshrs(c.mshr_entries, c.mshr_merges), dram(channel) {}
    modules::L2Slice::Config config;
    modules::SectorCacheTags tags;
    modules::MshrTable mshrs;
    modules::RingQueue<Arrival> pipe;
    modules::RingQueue<Fill> fills;
    modules::RingQueue<DramRequest> to_dram;
    modules::DramChannel dram;
    Cycle input_free = 0;
    Cycle lookup_next = 0;  ///< earliest cycle of the next access to the tags; kNever: waits for a fill
    bool waits_for_dram = false;
    Cycle send_free = 0;      ///< towards the DRAM, core cycles
    Cycle reply_free = 0;     ///< towards the crossbar, core cycles
    Cycle arrival_free = 0;   ///< memory clock of the next request
    Cycle response_free = 0;  ///< memory clock of the next response
    Cycle mshr_counted = 0;
    std::uint64_t outstanding = 0;  ///< in the DRAM
  };
  struct Port {
    std::vector<Reply> waiting;  ///< not in order
    modules::RingQueue<Reply> replies;
    Cycle free = 0;
  };

  Cycle next_of(const Slice& slice) const;
  void cross(Cycle end);
  void run_slice(unsigned index, Cycle begin, Cycle end);
  bool fill(unsigned index, Cycle now, const Fill& fill);
  void look_up(unsigned index, Cycle now);
  bool read(unsigned index, Cycle now, const modules::MemoryRequest& access);
  bool write(unsigned index, Cycle now, const modules::MemoryRequest& access);
  bool room_for_victim(const Slice& slice, std::uint64_t local) const;
  modules::SectorCacheTags::Slot allocate(unsigned index, Cycle now, std::uint64_t local);
  void ask_dram(unsigned index, Cycle now, std::uint64_t address, std::uint32_t context, bool write);
  void run_dram(Slice& slice, Cycle end);
  void reply(unsigned index, Cycle now, const modules::MemoryResponse& response);
  void deliver(Cycle end);
  void count_mshr_cycles(unsigned index, Cycle now);

  std::uint64_t core_fs_, memory_fs_;  ///< clock periods
  Cycle link_;                         ///< from an L1 to the crossbar
  Cycle latency_;  ///< crossbar with the link before it: from leaving an L1 or a slice to being seen at the other end
  Cycle pipe_;     ///< of a slice: from its input to its tags
  std::size_t capacity_;  ///< requests between the crossbar's arbiter and the tags of a slice
  Cycle now_ = 0;         ///< what slices have done is all before it
  modules::AddressInterleave interleave_;
  modules::Dram::Config dram_;
  unsigned sector_bytes_;
  std::vector<Input> inputs_;  ///< by SM
  unsigned first_input_ = 0;   ///< of equals this one crosses first (the cycle model keeps one an output)
  std::vector<Slice> slices_;
  std::vector<modules::L2Counters> l2_;
  std::vector<Port> ports_;
  std::uint64_t packets_ = 0;
  std::uint64_t responses_ = 0;
  std::uint64_t full_clocks_ = 0;
};

}  // namespace grtx::tlm
