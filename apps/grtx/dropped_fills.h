// A machine whose L1 cannot keep what it fetches says so.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string_view>

namespace grtx::sim {

/// A line on stderr if more than one in a thousand fills of the L1 were dropped. statistics: `stats` of a document.
void warn_of_dropped_fills(const nlohmann::ordered_json& statistics, std::string_view design);

}  // namespace grtx::sim
