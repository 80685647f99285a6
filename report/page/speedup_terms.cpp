// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/page/speedup_terms.h"

#include <array>
#include <cmath>

namespace grtx::report {
namespace {

constexpr std::size_t kTerms = 8;
constexpr std::array<const char*, kTerms> kNames = {"visits",
                                                    "fetches per visit",
                                                    "latency of a fetch",
                                                    "shader instructions",
                                                    "waits of shaders for memory",
                                                    "fetches under way per warp",
                                                    "resident warps",
                                                    "residual: cycles per shader instruction"};
using Values = std::array<double, kTerms>;

Values values_of(const StatisticValue& value) {
  const double visits = value("gpu.rt.node_visits"), fetches = value("gpu.rt.node_fetches");
  const double latency = value("gpu.rt.node_fetch_latency"), instructions = value("gpu.simt.instructions.total");
  const double warps = value("gpu.simt.resident_warp_cycles");
  const double traversal = value("gpu.simt.warp_cycles.trace") + value("gpu.simt.warp_cycles.fetch");
  const double waits = value("gpu.simt.warp_cycles.memory") + value("gpu.simt.warp_cycles.drain");
  return {visits,
          fetches / visits,
          latency,
          instructions,
          waits,
          fetches * latency / traversal,
          warps / value("gpu.cycles"),
          (warps - traversal - waits) / instructions};
}

double cycles_of(const Values& v) { return (v[0] * v[1] * v[2] / v[5] + v[3] * v[7] + v[4]) / v[6]; }

}  // namespace

std::vector<SpeedupTerm> speedup_terms(const StatisticValue& over, const StatisticValue& of) {
  const Values from = values_of(over), to = values_of(of);
  Values mixed = from;
  double before = cycles_of(mixed);
  std::vector<SpeedupTerm> terms;
  for (std::size_t i = 0; i < kTerms; ++i) {
    mixed[i] = to[i];
    const double cycles = cycles_of(mixed);
    if (!std::isfinite(before / cycles)) return {};
    terms.push_back({kNames[i], from[i], to[i], cycles, before / cycles});
    before = cycles;
  }
  return terms;
}

std::vector<SpeedupTerm> speedup_terms(const DesignResult& over, const DesignResult& of) {
  return speedup_terms([&over](const std::string& name) { return over.value(name); },
                       [&of](const std::string& name) { return of.value(name); });
}

}  // namespace grtx::report
