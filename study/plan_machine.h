// SPDX-License-Identifier: Apache-2.0
// The base machine of a sweep's plan.
#pragma once

#include <string>

#include "grtx/lab/sweep/plan.h"

namespace grtx::study {

/// Makes a machine ("" for none) the base of the plan; the plan's own settings override it. Throws Error if there is no
/// such machine.
void put_on_machine(lab::SweepPlan& plan, const std::string& machine);

}  // namespace grtx::study
