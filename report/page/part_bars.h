// SPDX-License-Identifier: Apache-2.0
// Stacked bars of parts, as a chart and as a table.
#pragma once

#include <string>
#include <vector>

namespace grtx::report {

struct Part {
  std::string name;
  double value = 0.0;
};
struct Bar {
  std::string label;
  std::vector<Part> parts;
};
/// Titles of a chart of bars. unit: "J", "B"; "" for counts.
struct BarWords {
  std::string id, value_title, unit, part_title, caption;
};

/// The chart alone; "" without a bar. With more than 12 parts the smallest become "other".
std::string bars_chart(const BarWords& words, std::vector<Bar> bars);
/// The chart, and its numbers in a folded table.
std::string bars_html(const BarWords& words, std::vector<Bar> bars);

}  // namespace grtx::report
