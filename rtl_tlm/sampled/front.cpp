#include "rtl_tlm/sampled/front.h"

#include "rtl_tlm/gpu.h"
#include "rtl_tlm/trace_source.h"

namespace grtx::tlm {
namespace {

class LaunchList final : public modules::WarpObserver {
 public:
  void launched(unsigned sm, unsigned /*slot*/, const traces::RayGroup& /*group*/, Cycle now) override {
    list.push_back({sm, static_cast<double>(now)});
  }
  void ended(unsigned /*sm*/, unsigned /*slot*/, Cycle /*now*/) override {}
  std::vector<Launch> list;
};

}  // namespace

std::vector<Launch> first_launches(const traces::Reader& reader, const GpuConfig& config, Cycle cycles) {
  constexpr unsigned kDecodeAhead = 32;
  modules::set_time_resolution_to_fs();
  TraceSource source(reader, kDecodeAhead);
  LaunchList launches;
  Gpu gpu("gpu", config, reader.header(), reader.totals().max_evictions_per_ray, source, {});
  const std::unique_ptr<BuiltInDram> memory = bind_built_in_dram(gpu, {});
  gpu.distributor().observe(&launches);
  sc_core::sc_start(sc_core::sc_time::from_value(cycles * gpu.core().period_fs()), sc_core::SC_RUN_TO_TIME);
  return launches.list;
}

}  // namespace grtx::tlm
