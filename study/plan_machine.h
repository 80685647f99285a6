// The base machine of a sweep's plan.
#pragma once

#include <string>

#include "grtx/lab/sweep/plan.h"

namespace grtx::sim {

/// Makes a machine ("" for none) the base of the plan; the plan's own settings override it. Throws Error if there is no
/// such machine.
void put_on_machine(SweepPlan& plan, const std::string& machine);

}  // namespace grtx::sim
