// SPDX-License-Identifier: Apache-2.0
// The machines of a sweep's plan: the base, and those that it varies.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "grtx/explore/sweep/plan.h"

namespace grtx::experiment {

/// Makes a machine ("" for none; nullopt: the plan's own, else the default), with the plan's file over it, the base of
/// the plan, and reads the machines that it varies; the plan's designs and settings lie over all. Returns all files
/// that were read. Throws Error if there is no such machine, or two have one name.
std::vector<std::string> put_on_machine(explore::SweepPlan& plan, const std::optional<std::string>& machine);

}  // namespace grtx::experiment
