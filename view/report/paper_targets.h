// The paper's figures beside the model's.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/view/report/run_results.h"

namespace grtx::sim {

/// A figure of the paper that follows from the statistics of a run's designs.
struct RunTarget {
  std::string name;
  double paper = 0.0;
  bool at_least = false;
  std::string source;     ///< place in the paper
  std::string statistic;  ///< of design `over` divided by that of `of`; of `of` alone when `over` is ""
  std::string over, of;

  bool ratio() const { return !over.empty(); }
  /// NaN when the run lacks a design or the statistic.
  double of_run(const RunResults& run) const;
};

/// A figure of the paper that follows from the cost model.
struct CostTarget {
  std::string name;
  double paper = 0.0;
  std::string unit;  ///< B, MiB or GiB
  std::string source;
  std::string figure;  ///< checkpoint_storage: of an RT unit; buffers: in global memory, of `sms` SMs
  unsigned sms = 0;

  /// cost: as `grtx cost --json` of a design with checkpointing. In `unit`.
  double of_machine(const nlohmann::ordered_json& cost) const;
};

const std::vector<RunTarget>& run_targets();
const std::vector<CostTarget>& cost_targets();

}  // namespace grtx::sim
