// SPDX-License-Identifier: Apache-2.0
// The answer of a sweep, as text and at the top of its page: the front of time against the plan's area in its first
// view, each entry the fastest of its area or less, and the points of least time, area and energy.
#pragma once

#include <string>

#include "grtx/report/page/sweep_results.h"

namespace grtx::report {

/// For a terminal; "" if no point is finished.
std::string sweep_answer_text(const SweepResults& results);
/// The same as a table; "" if no point is finished.
std::string sweep_answer_html(const SweepResults& results);

}  // namespace grtx::report
