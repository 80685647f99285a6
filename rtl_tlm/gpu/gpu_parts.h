// SPDX-License-Identifier: Apache-2.0
// Factories of a GPU's units; an empty one stands for the project's own class. They let a unit of yours replace one of
// ours without editing the project's files.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "grtx/modules/cache/l1_cache_if.h"
#include "grtx/modules/cache/l2_slice_if.h"
#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/noc/crossbar_if.h"
#include "grtx/modules/rt_unit/node_port/node_port_if.h"
#include "grtx/modules/rt_unit/rt_unit_if.h"
#include "grtx/modules/simt/simt_core_if.h"
#include "grtx/modules/simt/work_distributor_if.h"
#include "grtx/traces/header.h"

namespace grtx::sim {

/// References passed to a factory outlive the unit that it makes.
struct SmParts {
  std::function<std::unique_ptr<modules::SimtCoreModule>(const char* name, modules::ClockDomain& clock,
                                                         const modules::SimtCoreConfig& config,
                                                         const traces::Header& header, const modules::MemoryMap& map)>
      simt_core;
  /// sm: number of the SM.
  std::function<std::unique_ptr<modules::RtUnitModule>(const char* name, const modules::RtUnitConfig& config,
                                                       const traces::Header& header, const modules::MemoryMap& map,
                                                       modules::ClockDomain& clock, unsigned sm)>
      rt_unit;
  modules::RtUnitParts rt_parts;  ///< parts of our own RT unit
  /// Between the node port of each RT unit and the L1; without a factory there is no such unit.
  std::function<std::unique_ptr<modules::NodePortModule>(const char* name, modules::ClockDomain& clock)> node_port;
  std::function<std::unique_ptr<modules::L1CacheModule>(const char* name, const modules::L1CacheConfig& config,
                                                        modules::ClockDomain& clock)>
      l1_cache;
};

struct GpuParts {
  SmParts sm;
  std::function<std::unique_ptr<modules::WorkDistributorModule>(const char* name, modules::ClockDomain& clock,
                                                                const modules::WorkDistributorConfig& config,
                                                                modules::GroupSource& source)>
      work_distributor;
  std::function<std::unique_ptr<modules::CrossbarModule>(const char* name, const modules::CrossbarConfig& config,
                                                         modules::ClockDomain& clock)>
      crossbar;
  std::function<std::unique_ptr<modules::L2SliceModule>(const char* name, const modules::L2SliceConfig& config,
                                                        modules::ClockDomain& clock)>
      l2_slice;
};

struct GpuConfig;

/// Fills factories for a machine with this configuration.
using PartsOfMachine = std::function<void(const GpuConfig& config, GpuParts& parts)>;
/// Calls `parts` for every GPU that this program builds from now on, in whichever command.
void register_parts(PartsOfMachine parts);
/// `parts` after all registered functions have filled in theirs.
GpuParts with_registered_parts(GpuParts parts, const GpuConfig& config);

/// Calls f(name, factory) for each factory. A new factory does not compile until it is named here.
template <typename F>
void for_each_factory(GpuParts& parts, F&& f) {
  auto& [sm, work_distributor, crossbar, l2_slice] = parts;
  auto& [simt_core, rt_unit, rt_parts, node_port, l1_cache] = sm;
  f("simt_core", simt_core);
  f("rt_unit", rt_unit);
  modules::for_each_factory(rt_parts, f);
  f("node_port", node_port);
  f("l1_cache", l1_cache);
  f("work_distributor", work_distributor);
  f("crossbar", crossbar);
  f("l2_slice", l2_slice);
}

}  // namespace grtx::sim
