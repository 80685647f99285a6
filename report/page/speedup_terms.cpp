// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/page/speedup_terms.h"

#include <array>
#include <bit>
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

constexpr std::size_t kMixtures = std::size_t{1} << kTerms;

/// Logarithms of cycles; bit i of the index: term i is the other design's.
std::array<double, kMixtures> mixtures(const Values& from, const Values& to) {
  std::array<double, kMixtures> found{};
  for (std::size_t mask = 0; mask < kMixtures; ++mask) {
    Values mixed = from;
    for (std::size_t i = 0; i < kTerms; ++i) {
      if ((mask >> i & 1U) != 0) mixed[i] = to[i];
    }
    found[mask] = std::log(cycles_of(mixed));
  }
  return found;
}

/// Logarithm of the speed-up by a term: the mean over all orders in which terms can be exchanged (Shapley's value).
double share_of(std::size_t term, const std::array<double, kMixtures>& cycles) {
  constexpr std::array<double, kTerms> kOrders = {5040, 720, 240, 144,
                                                  144,  240, 720, 5040};  // n! (7 - n)! for n before
  constexpr double kAll = 40320;                                          // 8!
  const std::size_t bit = std::size_t{1} << term;
  double sum = 0.0;
  for (std::size_t mask = 0; mask < kMixtures; ++mask) {
    if ((mask & bit) != 0) continue;
    sum += kOrders.at(static_cast<std::size_t>(std::popcount(mask))) * (cycles[mask] - cycles[mask | bit]);
  }
  return sum / kAll;
}

}  // namespace

std::vector<SpeedupTerm> speedup_terms(const StatisticValue& over, const StatisticValue& of) {
  const Values from = values_of(over), to = values_of(of);
  const std::array<double, kMixtures> cycles = mixtures(from, to);
  double logarithm = cycles.front();
  std::vector<SpeedupTerm> terms;
  for (std::size_t i = 0; i < kTerms; ++i) {
    const double share = share_of(i, cycles);
    if (!std::isfinite(share)) return {};
    logarithm -= share;
    terms.push_back({kNames[i], from[i], to[i], std::exp(logarithm), std::exp(share)});
  }
  return terms;
}

std::vector<SpeedupTerm> speedup_terms(const DesignResult& over, const DesignResult& of) {
  return speedup_terms([&over](const std::string& name) { return over.value(name); },
                       [&of](const std::string& name) { return of.value(name); });
}

}  // namespace grtx::report
