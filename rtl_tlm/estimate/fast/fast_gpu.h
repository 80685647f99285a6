// The GPU in fast mode: loosely timed, without the SystemC kernel. It makes the decisions of the cycle model (which SM,
// which warp buffer entry, what is merged, hit, prefetched, checkpointed, blended), but a visit of a node is one event,
// and what its requests meet on their way are resources that they reserve. docs/model/fast-mode.md
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "grtx/base/state_bytes.h"
#include "grtx/modules/simt/work_distributor.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/gpu_counters.h"

namespace grtx::sim {

/// fast.stride, or if that is 0 the largest, up to 4, with which so many visits leave 500,000 that take time: then
/// cycles change by some 1 % (docs/model/fast-mode.md).
unsigned fast_stride(const GpuConfig& config, std::uint64_t visits);

namespace fast {
class Machine;
}

class FastGpu {
 public:
  /// header and source must outlive the GPU. stride: one in so many of a lane's events takes time. Throws Error when
  /// the configuration asks for what this mode does not model.
  FastGpu(const GpuConfig& config, const traces::Header& header, std::uint64_t eviction_entries,
          modules::GroupSource& source, unsigned stride);
  ~FastGpu();

  /// Before run(); must outlive it.
  void observe(modules::WarpObserver* observer);
  /// Which SMs the first groups go to, in launch order.
  void assign(std::vector<unsigned> sms);
  /// Before run(): caches and open rows as `before`, of the same configuration, has left them; it cannot be used after.
  void keep(FastGpu& before);
  /// After run(): what keep() takes over, for a run in another process. load(): before run(), on the same machine.
  void save(StateWriter& state) const;
  void load(StateReader& state);
  /// Runs all groups to the end and drains. progress(groups ended) is called now and then. Throws std::runtime_error
  /// when nothing is due although work remains, and Error when the trace contradicts itself.
  void run(const std::function<void(std::uint64_t)>& progress);
  /// After run().
  GpuCounters counters() const;
  /// Nothing inside.
  bool idle() const;
  std::uint64_t steps() const;  ///< cycles in which something was due

 private:
  std::unique_ptr<fast::Machine> machine_;
};

}  // namespace grtx::sim
