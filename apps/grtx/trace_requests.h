// SPDX-License-Identifier: Apache-2.0
// Makes traces for a sweep in one process, reusing scene and structure from trace to trace.
#pragma once

#include <cstdio>
#include <istream>

namespace grtx::apps {

/// Each line of `requests` is a JSON list with the arguments of `grtx trace`. After writing that trace, prints a line
/// to `answers`: {"scenes_read": 0 or 1, "structures_built": 0 or 1}. Returns 0 at the end of the requests; exceptions
/// of a trace are passed on and end the loop.
int answer_trace_requests(std::istream& requests, std::FILE* answers);

}  // namespace grtx::apps
