// SPDX-License-Identifier: Apache-2.0
// The paper's results, for comparison with the model's.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/report/page/run_results.h"

namespace grtx::report {

/// A result of the paper that can be computed from the statistics of a run.
struct RunTarget {
  std::string name;
  double paper = 0.0;
  bool at_least = false;
  std::string source;     ///< section, figure or table of the paper
  std::string statistic;  ///< statistic of design `over` divided by that of `of`; only of `of` if `over` is ""
  std::string over, of;

  bool ratio() const { return !over.empty(); }
  /// Value of a run; NaN if it lacks a design or the statistic.
  double of_run(const RunResults& run) const;
};

/// A result of the paper that can be computed by the cost model.
struct CostTarget {
  std::string name;
  double paper = 0.0;
  std::string unit;  ///< B, MiB or GiB
  std::string source;
  std::string figure;  ///< "checkpoint_storage": per RT unit; "buffers": in global memory, for `sms` SMs
  unsigned sms = 0;

  /// Value of a machine in `unit`. cost: as `grtx cost --json`, of a design with checkpointing.
  double of_machine(const nlohmann::ordered_json& cost) const;
};

/// Hits of a round in the paper's evaluation.
unsigned paper_k();
/// "k = 16 over 32" where a run has one of a simulated figure's designs at another k than the paper; "" where its k is
/// the paper's or is not known.
std::string other_k(const RunTarget& target, const RunResults& run);
const std::vector<RunTarget>& run_targets();
const std::vector<CostTarget>& cost_targets();

}  // namespace grtx::report
