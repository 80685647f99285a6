// SPDX-License-Identifier: Apache-2.0
// The table of the RT unit's parts: what each brings for energy, cost, lower bounds, idle keys, observers and reports.
#pragma once

#include <functional>
#include <vector>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/rt_unit/part/part_info.h"
#include "grtx/modules/rt_unit/rt_unit_config.h"

namespace grtx::modules {

/// All parts in the order of the data flow, also those that this configuration does not use, and after them those of
/// add_part().
std::vector<PartInfo> part_table(const RtUnitConfig& config, const OwnKeys& own);

/// Adds a part of somebody's own, once, before the first run. own: values of its keys.
void add_part(std::function<PartInfo(const OwnKeys& own)> part);

}  // namespace grtx::modules
