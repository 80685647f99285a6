// The machine on which a sweep's plan lies.
#pragma once

#include <string>

#include "grtx/lab/sweep/plan.h"

namespace grtx::sim {

/// Puts a machine ("" for none) below whatever the plan says. Throws Error for one that does not exist.
void put_on_machine(SweepPlan& plan, const std::string& machine);

}  // namespace grtx::sim
