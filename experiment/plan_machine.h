// SPDX-License-Identifier: Apache-2.0
// The base machine of a sweep's plan.
#pragma once

#include <string>
#include <vector>

#include "grtx/explore/sweep/plan.h"

namespace grtx::experiment {

/// Makes a machine ("" for none), with the plan's file over it, the base of the plan; the plan's designs and settings
/// lie over both. Returns all files that were read. Throws Error if there is no such machine.
std::vector<std::string> put_on_machine(explore::SweepPlan& plan, const std::string& machine);

}  // namespace grtx::experiment
