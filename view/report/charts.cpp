// SPDX-License-Identifier: Apache-2.0
#include "grtx/view/report/charts.h"

#include <algorithm>
#include <map>
#include <set>

#include "grtx/base/json.h"

namespace grtx::view {
namespace {

using nlohmann::ordered_json;

// Number of colours defined in report.css; further values reuse them.
constexpr unsigned kColours = 12;
constexpr std::size_t kBarPixels = 20;  // height of a bar and its gap; same value in report.js

ordered_json palette() {
  ordered_json range = ordered_json::array();
  for (unsigned i = 1; i <= kColours; ++i) range.push_back("var(--c" + std::to_string(i) + ")");
  return range;
}

ordered_json base(const ordered_json& rows) {
  return {
      {"width", "container"}, {"autosize", {{"type", "fit-x"}, {"contains", "padding"}}}, {"data", {{"values", rows}}}};
}

ordered_json quantity(const std::string& field, const std::string& title) {
  return {{"field", field}, {"type", "quantitative"}, {"title", title}};
}

/// An axis from 0; logarithmic where the values of a view span more than a factor of 20.
ordered_json from_zero(const ordered_json& rows, const std::string& field) {
  constexpr double kWide = 20.0;
  std::map<std::string, std::pair<double, double>> ranges;  // by view
  for (const ordered_json& row : rows) {
    if (!row.contains(field) || !row.at(field).is_number()) continue;
    const double value = row.at(field).get<double>();
    const auto [range, is_new] =
        ranges.try_emplace(row.contains("view") ? json_text(row.at("view")) : "", std::pair(value, value));
    range->second = {std::min(range->second.first, value), std::max(range->second.second, value)};
  }
  bool positive = true, wide = false;
  for (const auto& [view, range] : ranges) {
    positive = positive && range.first > 0.0;
    wide = wide || range.second > kWide * range.first;
  }
  if (positive && wide) return {{"type", "log"}, {"padding", 12}};
  return {{"zero", true}, {"nice", true}};
}

ordered_json tooltips(const std::vector<ChartField>& fields) {
  ordered_json list = ordered_json::array();
  for (const ChartField& f : fields) {
    list.push_back({{"field", f.field}, {"title", f.title}});
    if (f.measured) list.back().update({{"type", "quantitative"}, {"format", ",.5~r"}});
  }
  return list;
}

}  // namespace

ordered_json pareto_chart(const ordered_json& rows, const ChartField& time, const ChartField& cost,
                          const std::vector<ChartField>& tooltip, const std::string& colour_by) {
  ordered_json x = quantity(time.field, time.title);
  x["scale"] = from_zero(rows, time.field);
  ordered_json y = quantity(cost.field, cost.title);
  y["scale"] = from_zero(rows, cost.field);

  ordered_json line;
  line["transform"] = {{{"filter", "datum.front"}}};
  line["mark"] = {{"type", "line"}, {"interpolate", "step-after"}, {"color", "var(--muted)"}, {"strokeDash", {4, 3}}};
  line["encoding"] = {{"x", x}, {"y", y}, {"order", {{"field", time.field}}}};

  ordered_json points;
  points["name"] = "points";
  points["params"] = {{{"name", "brush"}, {"select", {{"type", "interval"}}}}};
  points["mark"] = {{"type", "point"}, {"filled", true}, {"stroke", "var(--card)"}, {"strokeWidth", 0.5}};
  points["encoding"] = {
      {"x", x},
      {"y", y},
      {"color",
       {{"field", "colour"},
        {"type", "ordinal"},
        {"scale", {{"range", palette()}}},
        {"legend", {{"title", nullptr}, {"orient", "bottom"}}}}},
      {"size", {{"condition", {{"test", "datum.front"}, {"value", 130}}}, {"value", 50}}},
      {"opacity",
       {{"condition", {{"test", "picked === null || indexof(picked, datum.id) >= 0"}, {"value", 0.9}}},
        {"value", 0.12}}},
      {"tooltip", tooltips(tooltip)}};

  ordered_json spec = base(rows);
  spec["height"] = 300;
  spec["params"] = {{{"name", "picked"}, {"value", nullptr}},
                    {{"name", "shown"}, {"value", 0}},
                    {{"name", "colour_by"}, {"value", colour_by}}};
  spec["transform"] = {{{"filter", "datum.view === shown"}}, {{"calculate", "datum[colour_by]"}, {"as", "colour"}}};
  spec["layer"] = ordered_json::array({line, points});
  return spec;
}

ordered_json stacked_bars(const ordered_json& rows, const std::vector<std::string>& parts,
                          const std::string& value_title, const std::string& part_title, bool linked) {
  ordered_json spec = base(rows);
  std::set<std::string> bars;  // drawn at first
  for (const ordered_json& row : rows) {
    if (!linked || (row.at("front").get<bool>() && row.at("view") == 0))
      bars.insert(row.at("label").get<std::string>());
  }
  spec["height"] = kBarPixels * std::max<std::size_t>(1, bars.size());
  ordered_json transform = ordered_json::array();
  if (linked) {
    spec["params"] = {{{"name", "picked"}, {"value", nullptr}}, {{"name", "shown"}, {"value", 0}}};
    transform.push_back(
        {{"filter", "datum.view === shown && (picked === null ? datum.front : indexof(picked, datum.id) >= 0)"}});
  }
  transform.push_back({{"calculate", "indexof(" + json_text(ordered_json(parts)) + ", datum.part)"}, {"as", "place"}});
  spec["transform"] = transform;
  spec["mark"] = {{"type", "bar"}};
  ordered_json x = quantity("value", value_title);
  x["stack"] = "zero";
  x["axis"] = {{"format", "~s"}};
  spec["encoding"] = {
      {"y",
       {{"field", "label"}, {"type", "nominal"}, {"title", nullptr}, {"sort", {{"field", "order"}, {"op", "min"}}}}},
      {"x", x},
      {"color",
       {{"field", "part"},
        {"type", "nominal"},
        {"scale", {{"domain", parts}, {"range", palette()}}},
        {"legend", {{"title", nullptr}, {"orient", "bottom"}}}}},
      {"order", {{"field", "place"}}},
      {"tooltip",
       {{{"field", "label"}, {"title", "of"}},
        {{"field", "part"}, {"title", part_title}},
        {{"field", "value"}, {"type", "quantitative"}, {"title", value_title}, {"format", ",.4~g"}},
        {{"field", "share"}, {"type", "quantitative"}, {"title", "share"}, {"format", ".1%"}}}}};
  return spec;
}

ordered_json ratio_bars(const ordered_json& rows, const ordered_json& paper, const std::vector<std::string>& labels,
                        const std::vector<std::string>& series, const std::string& value_title) {
  ordered_json spec = base(rows);
  spec["height"] = labels.size() * (14 + 14 * series.size());
  const ordered_json y = {{"field", "label"},
                          {"type", "nominal"},
                          {"title", nullptr},
                          {"sort", labels},
                          {"axis",
                           {{"labelExpr", "width < 420 ? split(datum.label, ', ') : datum.label"},
                            {"labelOffset", {{"expr", "width < 420 ? -7 : 0"}}}}}};
  ordered_json bars;
  bars["mark"] = {{"type", "bar"}};
  bars["encoding"] = {{"y", y},
                      {"x", quantity("value", value_title)},
                      {"tooltip",
                       {{{"field", "label"}, {"title", "figure"}},
                        {{"field", "series"}, {"title", "run"}},
                        {{"field", "value"}, {"type", "quantitative"}, {"title", "model"}, {"format", ".2f"}}}}};
  bars["encoding"]["color"] = {
      {"field", "series"},
      {"type", "nominal"},
      {"scale", {{"domain", series}, {"range", palette()}}},
      {"legend", series.size() > 1 ? ordered_json{{"title", nullptr}, {"orient", "bottom"}} : ordered_json(nullptr)}};
  if (series.size() > 1) bars["encoding"]["yOffset"] = {{"field", "series"}, {"sort", series}};
  ordered_json ticks;
  ticks["data"] = {{"values", paper}};
  ticks["mark"] = {{"type", "tick"}, {"color", "var(--ink)"}, {"thickness", 3}};
  ticks["encoding"] = {{"y", y},
                       {"x", quantity("value", value_title)},
                       {"tooltip",
                        {{{"field", "label"}, {"title", "figure"}},
                         {{"field", "value"}, {"type", "quantitative"}, {"title", "paper"}, {"format", ".2f"}}}}};
  spec["layer"] = ordered_json::array({bars, ticks});
  return spec;
}

ordered_json search_chart(const ordered_json& rows, const ChartField& x_field, const ChartField& y_field,
                          const std::vector<ChartField>& tooltip, const std::vector<std::string>& stages, bool line) {
  ordered_json x = quantity(x_field.field, x_field.title);
  x["scale"] = from_zero(rows, x_field.field);
  ordered_json y = quantity(y_field.field, y_field.title);
  y["scale"] = from_zero(rows, y_field.field);
  const std::string front = stages.at(stages.size() - 2);
  ordered_json spec = base(rows);
  spec["height"] = 300;
  spec["layer"] = ordered_json::array();
  if (line) {
    ordered_json steps;
    steps["transform"] = {{{"filter", {{"field", "stage"}, {"equal", front}}}}};
    steps["mark"] = {
        {"type", "line"}, {"interpolate", "step-after"}, {"color", "var(--muted)"}, {"strokeDash", {4, 3}}};
    steps["encoding"] = {{"x", x}, {"y", y}, {"order", {{"field", x_field.field}}}};
    spec["layer"].push_back(steps);
  }
  for (std::size_t i = 0; i < stages.size(); ++i) {
    const bool drawn = std::any_of(rows.begin(), rows.end(), [&](const ordered_json& row) {
      return row.at("stage").get<std::string>() == stages[i];
    });
    if (!drawn) continue;  // Vega warns about a layer without marks
    ordered_json points;
    points["transform"] = {{{"filter", {{"field", "stage"}, {"equal", stages[i]}}}}};
    points["mark"] = {{"type", "point"},         {"filled", true},
                      {"stroke", "var(--card)"}, {"size", i + 2 < stages.size() ? 40 : 130},
                      {"strokeWidth", 0.5},      {"opacity", i == 0 ? 0.45 : 0.95}};
    points["encoding"] = {{"x", x},
                          {"y", y},
                          {"color",
                           {{"field", "stage"},
                            {"type", "nominal"},
                            {"scale", {{"domain", stages}, {"range", palette()}}},
                            {"legend", {{"title", nullptr}, {"orient", "bottom"}}}}},
                          {"tooltip", tooltips(tooltip)}};
    spec["layer"].push_back(points);
  }
  return spec;
}

ordered_json waterfall(const ordered_json& rows, const std::string& value_title) {
  ordered_json spec = base(rows);
  spec["height"] = kBarPixels * rows.size();
  spec["mark"] = {{"type", "bar"}};
  spec["encoding"] = {
      {"y",
       {{"field", "label"}, {"type", "nominal"}, {"title", nullptr}, {"sort", {{"field", "order"}, {"op", "min"}}}}},
      {"x", quantity("before", value_title)},
      {"x2", {{"field", "after"}}},
      {"color",
       {{"field", "change"},
        {"type", "nominal"},
        {"scale", {{"domain", {"whole", "gain", "loss"}}, {"range", palette()}}},
        {"legend", nullptr}}},
      {"tooltip",
       {{{"field", "label"}, {"title", "change"}},
        {{"field", "before"}, {"type", "quantitative"}, {"format", ".4~f"}},
        {{"field", "after"}, {"type", "quantitative"}, {"format", ".4~f"}}}}};
  return spec;
}

ordered_json factor_chart(const ordered_json& rows, const std::vector<std::string>& parameters,
                          const std::string& factor_title) {
  constexpr std::size_t kRow = 38;  // pixels: marks and the values above them
  ordered_json spec = base(rows);
  spec["height"] = kRow * std::max<std::size_t>(1, parameters.size());
  const ordered_json y = {{"field", "parameter"}, {"type", "nominal"}, {"title", nullptr}, {"sort", parameters}};
  ordered_json x = quantity("factor", factor_title);
  x["scale"] = from_zero(rows, "factor");
  ordered_json range, points, words;
  range["mark"] = {{"type", "rule"}, {"color", "var(--muted)"}};
  range["encoding"] = {{"y", y}, {"x", x}, {"x2", {{"field", "factor"}, {"aggregate", "max"}}}};
  range["encoding"]["x"]["aggregate"] = "min";
  points["mark"] = {{"type", "point"}, {"filled", true}, {"size", 60}, {"color", "var(--c1)"}};
  points["encoding"] = {{"y", y},
                        {"x", x},
                        {"tooltip",
                         {{{"field", "parameter"}},
                          {{"field", "value"}},
                          {{"field", "factor"}, {"type", "quantitative"}, {"format", ".4~f"}},
                          {{"field", "candidates"}, {"type", "quantitative"}}}}};
  words["mark"] = {{"type", "text"}, {"dy", -10}, {"fontSize", 11}};
  words["encoding"] = {{"y", y}, {"x", x}, {"text", {{"field", "value"}}}};
  spec["layer"] = ordered_json::array({range, points, words});
  return spec;
}

ordered_json correlation_chart(const ordered_json& rows) {
  double low = 0.0, high = 0.0;
  for (const ordered_json& row : rows) {
    for (const char* side : {"measured", "simulated"}) {
      const double a = row.at(std::string(side) + "_low").get<double>();
      low = low == 0.0 ? a : std::min(low, a);
      high = std::max(high, row.at(std::string(side) + "_high").get<double>());
    }
  }
  const auto axis = [](const char* field) {
    ordered_json q = quantity(field, field);
    q["scale"] = {{"type", "log"}, {"nice", true}, {"padding", 12}};
    return q;
  };
  const auto rule = [&](const char* field, const char* across) {
    ordered_json layer;
    const std::string channel = std::string(field) == "measured" ? "x" : "y";
    layer["mark"] = {{"type", "rule"}, {"color", "var(--muted)"}};
    layer["encoding"][channel] = axis((std::string(field) + "_low").c_str());
    layer["encoding"][channel]["title"] = field;
    layer["encoding"][channel + "2"] = {{"field", std::string(field) + "_high"}};
    layer["encoding"][channel == "x" ? "y" : "x"] = axis(across);
    return layer;
  };
  ordered_json same;
  same["data"] = {{"values", {{{"measured", low}, {"simulated", low}}, {{"measured", high}, {"simulated", high}}}}};
  same["mark"] = {{"type", "line"}, {"color", "var(--muted)"}, {"strokeDash", {4, 3}}};
  same["encoding"] = {{"x", axis("measured")}, {"y", axis("simulated")}};
  ordered_json points;
  points["mark"] = {{"type", "point"}, {"filled", true}, {"size", 80}};
  points["encoding"] = {
      {"x", axis("measured")},
      {"y", axis("simulated")},
      {"color",
       {{"field", "kind"},
        {"type", "nominal"},
        {"scale", {{"domain", {"figure", "outlier"}}, {"range", palette()}}},
        {"legend", {{"title", nullptr}, {"orient", "bottom"}}}}},
      {"tooltip", tooltips({{"label", "figure"}, {"measured", "measured", true}, {"simulated", "simulated", true}})}};
  ordered_json spec = base(rows);
  spec["height"] = 360;
  spec["layer"] = ordered_json::array({same, rule("measured", "simulated"), rule("simulated", "measured"), points});
  return spec;
}

ordered_json series_lines(const ordered_json& rows, const std::string& value_title) {
  ordered_json spec = base(rows);
  spec["height"] = 160;
  spec["mark"] = {{"type", "line"}, {"interpolate", "step-before"}};
  ordered_json x = quantity("cycle", "core cycle");
  x["axis"] = {{"format", "~s"}};
  spec["encoding"] = {
      {"x", x},
      {"y", quantity("value", value_title)},
      {"color", {{"field", "series"}, {"type", "nominal"}, {"scale", {{"range", palette()}}}, {"legend", nullptr}}},
      {"tooltip",
       {{{"field", "series"}},
        {{"field", "cycle"}, {"type", "quantitative"}},
        {{"field", "value"}, {"type", "quantitative"}}}}};
  return spec;
}

}  // namespace grtx::view
