// SPDX-License-Identifier: Apache-2.0
// A speed-up taken apart: what each of a design's terms contributes on the way from the cycles of another design.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "grtx/report/page/run_results.h"

namespace grtx::report {

/// cycles = (visits x fetches per visit x latency / fetches under way per warp + instructions x cycles per instruction
/// + waits) / resident warps, of the cycles that warps spend in traceRay calls, in shaders, and there waiting for
/// memory: exact for each design, so that what no term explains is in the last.
struct SpeedupTerm {
  std::string name;     ///< "visits"
  double from = 0.0;    ///< its value in the design that speed-ups are over
  double to = 0.0;      ///< and in the other
  double cycles = 0.0;  ///< of the other design, times the factors of the terms that follow
  double factor = 0.0;  ///< speed-up by this term, the mean over all orders of terms; their product is the whole
};

/// value(name): a statistic, NaN if missing.
using StatisticValue = std::function<double(const std::string& name)>;
/// In this order: visits, fetches per visit, latency, shader instructions, waits of shaders, overlap (two terms),
/// residual. Empty if a statistic is missing.
std::vector<SpeedupTerm> speedup_terms(const StatisticValue& over, const StatisticValue& of);
/// The same of two designs.
std::vector<SpeedupTerm> speedup_terms(const DesignResult& over, const DesignResult& of);

}  // namespace grtx::report
