#include "grtx/rtl_tlm/run/first_launches.h"

#include <memory>
#include <nlohmann/json.hpp>

#include "grtx/base/child_process.h"
#include "grtx/base/json.h"
#include "grtx/rtl_tlm/gpu/gpu.h"
#include "grtx/rtl_tlm/gpu/memory_system.h"
#include "grtx/rtl_tlm/run/trace_source.h"

namespace grtx::sim {
namespace {

constexpr Cycle kCycles = 6000;

class LaunchList final : public modules::WarpObserver {
 public:
  void launched(unsigned sm, unsigned /*slot*/, const traces::RayGroup& /*group*/, Cycle now) override {
    list.push_back({sm, now});
  }
  void ended(unsigned /*sm*/, unsigned /*slot*/, Cycle /*now*/) override {}
  nlohmann::json list = nlohmann::json::array();
};

std::string simulate_front(const traces::Reader& reader, const std::vector<std::uint64_t>& groups,
                           const GpuConfig& config) {
  modules::set_time_resolution_to_fs();
  TraceSource source(reader, groups, kDecodeAhead);
  LaunchList launches;
  Gpu gpu("gpu", config, reader.header(), reader.totals().max_evictions_per_ray, source, {});
  const std::unique_ptr<MemorySystem> memory = memory_system(config.dram_model)(gpu, {});
  gpu.distributor().observe(&launches);
  run_for(gpu, kCycles);
  return json_text(launches.list);
}

}  // namespace

std::vector<Launch> first_launches(const traces::Reader& reader, const std::vector<std::uint64_t>& groups,
                                   const GpuConfig& config) {
  ChildProcess front("first_launches", [&] { return simulate_front(reader, groups, config); });
  std::vector<Launch> launches;
  for (const auto& launch : parse_json(front.result(), "launches")) {
    launches.push_back({launch.at(0).get<unsigned>(), launch.at(1).get<Cycle>()});
  }
  return launches;
}

}  // namespace grtx::sim
