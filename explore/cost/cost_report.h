// SPDX-License-Identifier: Apache-2.0
// A machine's cost as text, JSON and CSV.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/explore/cost/checkpoint_storage.h"
#include "grtx/explore/cost/cost_tree.h"
#include "grtx/explore/cost/run_energy.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::explore {

struct MachineCost {
  sim::GpuConfig config;
  std::string design;
  CostOptions options;
  CostNode tree;
  CheckpointStorage storage;  ///< of one RT unit; empty without checkpointing
  BufferSizes buffers;
  struct UnitLatency {
    std::string unit;
    unsigned configured = 0;
    unsigned fast = 0, slow = 0;  ///< cycles needed at the fast and slow ends of the process node's delay range
  };
  std::vector<UnitLatency> latencies;
};

/// Computes the cost of a machine. inventories: as machine_inventory() returns them.
MachineCost machine_cost(const sim::GpuConfig& config, const std::string& design,
                         const std::vector<modules::Inventory>& inventories, const CostOptions& options);

/// depth: levels of the hierarchy to print below the GPU. items: also list the parts of each module.
std::string cost_text(const MachineCost& cost, unsigned depth, bool items);
nlohmann::ordered_json cost_json(const MachineCost& cost);
std::string cost_csv(const MachineCost& cost);
/// Result of run_energy() as text and JSON, without parts that counted no action. frames: of the run, whose sum its
/// parts are.
std::string energy_text(const std::vector<EnergyPart>& parts, std::size_t frames = 1);
nlohmann::ordered_json energy_json(const std::vector<EnergyPart>& parts, std::size_t frames = 1);
/// A line for each of these parts.
std::string energy_csv(const std::vector<EnergyPart>& parts);
/// Every coefficient with its source and confidence, in Markdown.
std::string coefficient_reference();

}  // namespace grtx::explore
