// Traces for a sweep: one process, which keeps what the next trace can use.
#pragma once

#include <cstdio>
#include <istream>

namespace grtx::sim {

/// A line of `requests` is a JSON list: the arguments of `grtx trace`. Once that trace is written, a line of `answers`
/// says what it took: {"scenes_read": 0 or 1, "structures_built": 0 or 1}. Ends with the requests; throws what the
/// first trace throws that does not end well.
int answer_trace_requests(std::istream& requests, std::FILE* answers);

}  // namespace grtx::sim
