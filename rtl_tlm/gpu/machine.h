// The inventories of a whole machine: the very modules that a simulation would build, asked what they are made of.
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

/// Inventories of an elaborated machine: all modules of the GPU and, where the memory states them, its DRAM
/// controllers.
std::vector<modules::Inventory> inventory_of(const Gpu& gpu, const MemorySystem& memory);

/// A GPU that is built, and elaborated with whatever else the process elaborates, but has no work.
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

/// Elaborates the GPU once; like a simulation, once a process.
std::vector<modules::Inventory> machine_inventory(const GpuConfig& config, const MachineUse& use);

}  // namespace grtx::sim
