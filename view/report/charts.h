// Vega-Lite specifications of a report's charts. Colours are the page's (CSS variables), so that a chart follows the
// light and the dark scheme and prints.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace grtx::sim {

/// A field of the rows in a tooltip or an axis: its name in the data and what people read.
struct ChartField {
  std::string field;
  std::string title;
  bool measured = false;  ///< a quantity: five digits in a tooltip
};

/// Points of one cost against time, with their Pareto front as a step line, hover and an interval selection `brush`.
/// rows: {id, time, cost, front, group, ...}; a front is drawn for each group. The script sets the parameters `picked`
/// (null or a list of ids that are drawn in full) and `colour_by` (a field).
nlohmann::ordered_json pareto_chart(const nlohmann::ordered_json& rows, const ChartField& time, const ChartField& cost,
                                    const std::vector<ChartField>& tooltip, const std::string& colour_by);

/// One stacked bar a label. rows: {id, label, order, part, value, share}; labels are sorted by `order`; parts: in the
/// order of the stack. With `linked`, only bars with `front` are drawn until the script sets `picked`.
nlohmann::ordered_json stacked_bars(const nlohmann::ordered_json& rows, const std::vector<std::string>& parts,
                                    const std::string& value_title, const std::string& part_title, bool linked);

/// Bars of a ratio by label and series, and a tick where the paper's figure is. rows: {label, series, value};
/// paper: {label, value}.
nlohmann::ordered_json ratio_bars(const nlohmann::ordered_json& rows, const nlohmann::ordered_json& paper,
                                  const std::vector<std::string>& labels, const std::vector<std::string>& series,
                                  const std::string& value_title);

/// Candidates of a search in two of its objectives, with hover. rows: {x, y, stage, ...}; stages: in the order of their
/// colours, drawn one over the other; the last but one is the front, which `line` joins.
nlohmann::ordered_json search_chart(const nlohmann::ordered_json& rows, const ChartField& x, const ChartField& y,
                                    const std::vector<ChartField>& tooltip, const std::vector<std::string>& stages,
                                    bool line);

/// Changes one after another, each a bar from what was before to what is after. rows: {label, order, before, after,
/// change}; `change` is "whole" (a bar from 0), "gain" or "loss".
nlohmann::ordered_json waterfall(const nlohmann::ordered_json& rows, const std::string& value_title);

/// Factors of the values of parameters. rows: {parameter, value, factor, candidates}; parameters: in order.
nlohmann::ordered_json factor_chart(const nlohmann::ordered_json& rows, const std::vector<std::string>& parameters,
                                    const std::string& factor_title);

/// Simulated against measured values, both with their ranges, and the line on which they are the same. rows: {label,
/// kind, measured, measured_low, measured_high, simulated, ...}; kind: "figure" or "outlier".
nlohmann::ordered_json correlation_chart(const nlohmann::ordered_json& rows);

/// Lines over time. rows: {cycle, series, value}.
nlohmann::ordered_json series_lines(const nlohmann::ordered_json& rows, const std::string& value_title);

}  // namespace grtx::sim
