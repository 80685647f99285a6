// SPDX-License-Identifier: Apache-2.0
// Brings base/declare into this namespace: the parameters, counter tables, statistics and registries that a unit
// declares beside its Config and counters.
#pragma once

#include "grtx/base/declare/counter_table.h"
#include "grtx/base/declare/own_counts.h"
#include "grtx/base/declare/own_keys.h"
#include "grtx/base/declare/parameter.h"
#include "grtx/base/declare/registry.h"
#include "grtx/base/declare/statistics.h"

namespace grtx::modules {
using namespace declare;
}  // namespace grtx::modules
