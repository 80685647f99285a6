// SPDX-License-Identifier: Apache-2.0
// Vega-Lite specifications of a report's charts. Colours are CSS variables of the page, so that charts follow the light
// and dark scheme and print well.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace grtx::report {

/// A field shown in a tooltip or on an axis: its name in the rows and its title.
struct ChartField {
  std::string field;
  std::string title;
  bool measured = false;  ///< a number, shown with five digits in a tooltip
};

/// Colour of a design, the same on all pages; report.css has them.
std::string design_colour(const std::string& design);

/// One stacked bar per label. rows: {label, order, part, value, shown, share}, with `shown` the value as text; labels
/// are sorted by `order`; parts: in the order of the stack; unit: of `value`, "" for a count.
nlohmann::ordered_json stacked_bars(const nlohmann::ordered_json& rows, const std::vector<std::string>& parts,
                                    const std::string& value_title, const std::string& unit,
                                    const std::string& part_title);

/// Of series: those of charts, or of machines, which are shades, so that no machine has the colour of a design or part.
enum class SeriesColours { charts, machines };

/// Bars of a ratio by label and series, with a tick at the paper's value. rows: {label, series, value}; paper: {label,
/// value}.
nlohmann::ordered_json ratio_bars(const nlohmann::ordered_json& rows, const nlohmann::ordered_json& paper,
                                  const std::vector<std::string>& labels, const std::vector<std::string>& series,
                                  const std::string& value_title, SeriesColours colours = SeriesColours::charts);

/// Waterfall chart of successive changes, each a bar from the value before to the value after. rows: {label, order,
/// before, after, change}; `change` is "whole" (a bar from 0), "gain" or "loss".
nlohmann::ordered_json waterfall(const nlohmann::ordered_json& rows, const std::string& value_title);

/// Factors on a cost for each value of each parameter. rows: {parameter, value, factor, candidates}; parameters: in
/// order.
nlohmann::ordered_json factor_chart(const nlohmann::ordered_json& rows, const std::vector<std::string>& parameters,
                                    const std::string& factor_title);

/// Simulated over measured values, both with ranges, and the line of equality. rows: {label, kind, measured,
/// measured_low, measured_high, simulated, ...}; kind: "figure" or "outlier".
nlohmann::ordered_json correlation_chart(const nlohmann::ordered_json& rows);

/// Line chart over time, a line per design. rows: {cycle, part, series, value}; part: of the design's cycles, which is
/// the axis if there are several designs, since one may take a hundredth of another's.
nlohmann::ordered_json series_lines(const nlohmann::ordered_json& rows, const std::string& value_title,
                                    const std::vector<std::string>& designs);

}  // namespace grtx::report
