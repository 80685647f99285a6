// What fast mode counts on groups of a trace.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "grtx/rtl_tlm/estimate/fast/fast_gpu.h"
#include "grtx/rtl_tlm/run/first_launches.h"
#include "grtx/rtl_tlm/run/trace_source.h"

namespace grtx::sim::test {

/// groups: in launch order. known: SMs of the first ones, as seen.
inline GpuCounters fast_counters(const traces::Reader& reader, const std::vector<std::uint64_t>& groups,
                                 const std::vector<Launch>& known, const GpuConfig& config,
                                 modules::WarpObserver* observer = nullptr) {
  constexpr unsigned kDecodeAhead = 8;
  TraceSource source(reader, groups, kDecodeAhead);
  const std::uint64_t visits =
      reader.totals().visits() * groups.size() / std::max<std::uint64_t>(1, reader.group_count());
  FastGpu gpu(config, reader.header(), reader.totals().max_evictions_per_ray, source, fast_stride(config, visits));
  gpu.observe(observer);
  std::vector<unsigned> sms;
  for (const Launch& launch : known) sms.push_back(launch.sm);
  gpu.assign(std::move(sms));
  gpu.run([](std::uint64_t) {});
  return gpu.counters();
}

/// All groups of the trace, launched at once.
inline GpuCounters fast_counters(const traces::Reader& reader, const GpuConfig& config) {
  std::vector<std::uint64_t> groups(reader.group_count());
  std::iota(groups.begin(), groups.end(), std::uint64_t{0});
  return fast_counters(reader, groups, {}, config);
}

}  // namespace grtx::sim::test
