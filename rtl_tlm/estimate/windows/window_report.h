// SPDX-License-Identifier: Apache-2.0
// Completes an estimate from windows (inputs, interval, energy, host cost), or simulates the whole trace instead.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>

#include "grtx/rtl_tlm/estimate/windows/scaled_statistics.h"
#include "grtx/rtl_tlm/estimate/windows/window_simulation.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

class WindowReport {
 public:
  /// Starts measuring host time. The arguments must outlive it.
  WindowReport(const traces::Reader& reader, const GpuConfig& config, const WindowOptions& options);

  /// Size of the sample and how well the fit explains it.
  struct Sample {
    std::uint64_t groups = 0;  ///< simulated
    double residual = 0.0;
  };
  /// Adds gpu.windows.*. note: why the whole trace was simulated; empty if it was not.
  void describe(const EstimatedResult& result, const Sample& sample, const std::string& note,
                modules::StatisticList& list) const;
  /// Adds the energy statistics of the whole machine for the counts, if options.price is set: energy grows with each
  /// count, so the ends of its interval are prices of the counts' ends.
  void add_energy(WholeStatistics& statistics) const;
  /// Fills inputs, host.* and document of a result whose statistics are complete.
  void finish(EstimatedResult& result) const;
  /// Simulates the whole trace in cycle mode instead of estimating, and prints the reason `why` to stderr.
  EstimatedResult whole(const std::string& why) const;

 private:
  std::map<std::string, std::string> inputs() const;

  const traces::Reader& reader_;
  const GpuConfig& config_;
  const WindowOptions& options_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double start_cpu_;
};

}  // namespace grtx::sim
