// What every estimate from windows has around it: inputs, interval, energy, cost, and the whole trace in its place.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>

#include "grtx/rtl_tlm/estimate/windows/window_simulation.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

inline constexpr double kWholeFrom = 0.5;  ///< beyond this share the whole trace costs little more

class WindowReport {
 public:
  /// Starts the clocks of the host. All three outlive it.
  WindowReport(const traces::Reader& reader, const GpuConfig& config, const WindowOptions& options);

  /// What the interval rests on, beside itself.
  struct Sample {
    std::uint64_t groups = 0;  ///< simulated, distinct
    double residual = 0.0;
  };
  /// gpu.sampled.*. note: why the whole trace was simulated, if it was.
  void describe(const SampledResult& result, const Sample& sample, const std::string& note,
                modules::StatisticList& list) const;
  /// Energy of the whole machine for the counts in the list, if it is asked for.
  void add_energy(modules::StatisticList& list) const;
  /// Inputs, host.* and the document of a result whose statistics are complete.
  void finish(SampledResult& result) const;
  /// The whole trace in cycle mode: nothing is estimated. Says on stderr why.
  SampledResult whole(const std::string& why) const;

 private:
  std::map<std::string, std::string> inputs() const;

  const traces::Reader& reader_;
  const GpuConfig& config_;
  const WindowOptions& options_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double start_cpu_;
};

}  // namespace grtx::sim
