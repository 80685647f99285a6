// How far fast mode is off, from samples that both it and an engine have simulated.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/rtl_tlm/estimate/sampled/estimate.h"

namespace grtx::sim {

/// Standard deviation, on the logarithm, of the model's error on scaled machines: 16 designs of four scenes.
inline constexpr double kFastSpread = 0.01;

/// A sample as both ran it; all vectors by position.
struct FastSample {
  std::vector<std::uint64_t> groups;
  std::vector<double> weight;    ///< work of the group
  std::vector<double> end;       ///< cycles, of the engine
  std::vector<double> fast_end;  ///< of the model
};

struct FastCorrection {
  double log_factor = 0.0;  ///< to be added to the logarithm of the model's cycles
  double residual = 0.0;    ///< standard deviation of corrected ends less simulated ones over the mean end
  double prior_variance = 0.0;
  double degrees_of_freedom = 1.0;
  std::vector<GroupEvidence> evidence;
};

/// From the sum of ends over the sum of modelled ends, groups weighted by work; shrunk towards none by as much as the
/// samples scatter against kFastSpread. No correction without work. The weights of the evidence are 0: how far a
/// single end is off is part of the model's bias, which whole runs have measured.
FastCorrection correct_fast(const std::vector<FastSample>& samples);

}  // namespace grtx::sim
