// A machine's cost as text, JSON and CSV.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/lab/cost/checkpoint_storage.h"
#include "grtx/lab/cost/cost_tree.h"
#include "grtx/lab/cost/run_energy.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {

struct MachineCost {
  GpuConfig config;
  std::string design;
  CostOptions options;
  CostNode tree;
  CheckpointStorage storage;  ///< of one RT unit; no fields without checkpointing
  BufferSizes buffers;
  struct UnitLatency {
    std::string unit;
    unsigned configured = 0;
    unsigned fast = 0, slow = 0;  ///< cycles that the operators' delays ask for, at the ends of the node's delay
  };
  std::vector<UnitLatency> latencies;
};

/// Prices what machine_inventory() gave.
MachineCost machine_cost(const GpuConfig& config, const std::string& design,
                         const std::vector<modules::Inventory>& inventories, const CostOptions& options);

/// depth: levels of the hierarchy below the GPU; items: also what each module is made of.
std::string cost_text(const MachineCost& cost, unsigned depth, bool items);
nlohmann::ordered_json cost_json(const MachineCost& cost);
std::string cost_csv(const MachineCost& cost);
/// What run_energy() gave, without parts of which no action was counted.
std::string energy_text(const std::vector<EnergyPart>& parts);
nlohmann::ordered_json energy_json(const std::vector<EnergyPart>& parts);
/// Every coefficient with its source and confidence, in Markdown.
std::string coefficient_reference();

}  // namespace grtx::sim
