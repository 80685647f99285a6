// The machine of fast mode: the units of its SMs, the work distributor, and whose event it is.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "grtx/rtl_tlm/estimate/fast/distributor.h"
#include "grtx/rtl_tlm/estimate/fast/fast_l1.h"
#include "grtx/rtl_tlm/estimate/fast/fast_rt_unit.h"
#include "grtx/rtl_tlm/estimate/fast/fast_simt.h"
#include "grtx/rtl_tlm/estimate/fast/shared.h"
#include "grtx/rtl_tlm/gpu/gpu_counters.h"

namespace grtx::sim::fast {

class Machine {
 public:
  /// stride: one in so many of a lane's events takes time, a power of two.
  Machine(const GpuConfig& config, const traces::Header& header, std::uint64_t eviction_entries,
          modules::GroupSource& source, unsigned stride);

  void observe(modules::WarpObserver* observer) { distributor_.observe(observer); }
  void assign(std::vector<unsigned> sms) { distributor_.assign(std::move(sms)); }
  /// Before run(): caches and open rows as `before`, a machine of this configuration that has run, has left them.
  void keep(Machine& before);
  void save(StateWriter& state) const;
  void load(StateReader& state);
  void run(const std::function<void(std::uint64_t)>& progress);
  GpuCounters counters() const;
  bool idle() const;
  std::uint64_t steps() const { return shared_.agenda.steps(); }

 private:
  struct Sm {
    Sm(Shared& shared, unsigned index, Distributor& distributor)
        : l1(shared, index), rt(shared, index, l1, simt), simt(shared, index, l1, rt, distributor) {
      l1.connect(rt, simt);
    }
    L1 l1;
    RtUnit rt;
    Simt simt;
  };
  void handle(const Due& due);
  /// Nothing will be asked for before cycle `now` any more.
  void advance(Cycle now);

  Shared shared_;
  std::vector<std::unique_ptr<Sm>> sms_;
  Distributor distributor_;
  Cycle advanced_ = 0;  ///< when calendars were told of the time
};

}  // namespace grtx::sim::fast
