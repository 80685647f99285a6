// SPDX-License-Identifier: Apache-2.0
// Where the cycles of a run went, as text bars, from its statistics alone.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace grtx::sim {

struct StallBar {
  std::string label;
  double value = 0.0;
};

/// Bars that share one scale.
struct StallSection {
  std::string title;
  std::string unit;
  double whole = 0.0;  ///< value of a full bar
  std::vector<StallBar> bars;
};

/// Sections of a statistics document (grtx.stats/1): every group of statistics "X.stall.*", beginning with the RT
/// schedulers', whose busy cycles are added; activity of resident warps; pipelines of the intersection units; the
/// slowest call of a warp; lower bounds. file: for the Error that is thrown when the document is not of that kind or
/// holds no stalls.
std::vector<StallSection> stall_sections(const nlohmann::ordered_json& document, const std::string& file);

/// columns: characters of a full bar, at least 1.
std::string stall_text(const std::vector<StallSection>& sections, unsigned columns);

}  // namespace grtx::sim
