// SPDX-License-Identifier: Apache-2.0
// Inventories (storage and operators) of a whole machine, asked from the modules that a simulation would build.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "grtx/modules/kernel/inventory.h"
#include "grtx/rtl_tlm/gpu/gpu.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/machine_use.h"
#include "grtx/rtl_tlm/gpu/memory_system.h"

namespace grtx::sim {

/// Inventories of an elaborated machine: all modules of the GPU and, if the memory system has an inventory, its DRAM
/// controllers.
std::vector<modules::Inventory> inventory_of(const Gpu& gpu, const MemorySystem& memory);

/// An elaborated GPU without work, for its inventory.
class IdleMachine {
 public:
  /// config and header must outlive it. eviction_entries: see Gpu.
  IdleMachine(const GpuConfig& config, const traces::Header& header, std::uint64_t eviction_entries);
  ~IdleMachine();
  IdleMachine(const IdleMachine&) = delete;
  IdleMachine& operator=(const IdleMachine&) = delete;

  std::vector<modules::Inventory> inventory() const;

 private:
  std::unique_ptr<modules::GroupSource> none_;
  std::unique_ptr<Gpu> gpu_;
  std::unique_ptr<MemorySystem> memory_;
};

/// Elaborates a GPU. Throws std::logic_error if the process has elaborated already: it can only once, as in simulate().
std::vector<modules::Inventory> machine_inventory(const GpuConfig& config, const MachineUse& use);

}  // namespace grtx::sim
