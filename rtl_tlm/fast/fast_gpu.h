// The GPU in fast mode: the SMs advance in short turns, one after the other; what they share takes reservations out of
// order within a turn. docs/simulation-speed.md
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <systemc>
#include <vector>

#include "modules/memory_map.h"
#include "modules/work_distributor.h"
#include "rtl_tlm/fast/fast_memory.h"
#include "rtl_tlm/fast/fast_sm.h"
#include "rtl_tlm/gpu_config.h"
#include "rtl_tlm/gpu_counters.h"

namespace grtx::tlm {

/// What a configuration asks for that fast mode does not model; an empty key: nothing.
struct Unmodelled {
  const char* key = "";
  const char* rule = "";
  explicit operator bool() const { return *key != '\0'; }
};
Unmodelled unmodelled_by_fast(const GpuConfig& config);

class FastGpu final : public sc_core::sc_module {
 public:
  /// source must outlive the GPU. Throws Error when the configuration asks for what this mode does not model.
  FastGpu(const sc_core::sc_module_name& name, const GpuConfig& config, const traces::Header& header,
          std::uint64_t eviction_entries, modules::GroupSource& source);

  /// Before run(); must outlive it.
  void observe(modules::WarpObserver* observer) { observer_ = observer; }
  /// Which SMs the first groups go to, in launch order.
  void assign(std::vector<unsigned> sms) { assigned_ = std::move(sms); }
  /// Runs all groups to the end and drains. progress(groups ended) is called now and then. Throws std::runtime_error
  /// when nothing is due although work remains.
  void run(const std::function<void(std::uint64_t)>& progress);
  /// After run().
  const GpuCounters& counters() const { return counters_; }
  /// Nothing inside.
  bool idle() const;
  std::uint64_t steps() const { return steps_; }  ///< turns that SMs and memory took

 private:
  struct Work {
    LaneMask free_slots = 0;
    std::vector<std::uint64_t> position;  ///< of the group that runs in a slot
    std::uint64_t launched = 0;
    Cycle last_visible = 0;
  };

  void advance(Cycle end);
  Cycle next_due() const;
  void collect_ended(Cycle end);
  void launch_more(Cycle seen, Cycle earliest);
  bool held_back(Cycle now);
  void take_counters(bool drained);

  GpuConfig config_;
  modules::MemoryMap map_;
  modules::GroupSource& source_;
  modules::WarpObserver* observer_ = nullptr;
  std::vector<unsigned> assigned_;  ///< SMs of the first groups
  FastMemory memory_;
  std::vector<std::unique_ptr<FastSm>> sms_;
  std::vector<Work> work_;  ///< by SM
  std::uint64_t next_group_ = 0;
  std::uint64_t running_ = 0;
  unsigned turn_ = 0;
  const traces::RayGroup* ready_ = nullptr;  ///< acquired, not launched yet
  bool secondary_ = false;
  Cycle last_launch_ = 0;
  Cycle end_ = 0;          ///< when the last warp had ended
  Cycle primary_end_ = 0;  ///< the last primary one
  std::uint64_t steps_ = 0;
  GpuCounters counters_;
};

}  // namespace grtx::tlm
