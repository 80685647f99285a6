// The inventories of a whole machine: the very modules that a simulation would build, asked what they are made of.
#pragma once

#include <string>
#include <vector>

#include "modules/inventory.h"
#include "rtl_tlm/gpu.h"
#include "rtl_tlm/gpu_config.h"

namespace grtx::tlm {

/// Which units the machine must have.
struct MachineUse {
  std::string design = "grtx";  ///< baseline, sw, hw or grtx: two levels, checkpointing
  bool spheres = false;         ///< sphere units in place of triangle units
};

/// Of an elaborated machine: all modules of the GPU and the controllers of its DRAM.
std::vector<modules::Inventory> inventory_of(const Gpu& gpu, const modules::Dram& dram);

/// Elaborates the GPU once; like a simulation, once a process.
std::vector<modules::Inventory> machine_inventory(const GpuConfig& config, const MachineUse& use);

}  // namespace grtx::tlm
