// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/page/charts.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include "grtx/base/json.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;

// Number of colours defined in report.css; further values reuse them.
constexpr unsigned kColours = 12;
constexpr std::size_t kBarPixels = 20;  // height of a bar and its gap; same value in explore_charts.js

ordered_json palette(const std::string& name = "c", unsigned colours = kColours) {
  ordered_json range = ordered_json::array();
  for (unsigned i = 1; i <= colours; ++i) range.push_back("var(--" + name + std::to_string(i) + ")");
  return range;
}

/// Colour of a thing by its name in report.css, which alone knows them; `otherwise` if it has none.
std::string named_colour(const char* kind, std::string name, const std::string& otherwise) {
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '_') c = '-';
  }
  return std::string("var(--") + kind + "-" + name + ", " + otherwise + ")";
}

/// Of the parts of a bar: a part has one colour in all charts.
ordered_json part_palette(const std::vector<std::string>& parts) {
  ordered_json range = ordered_json::array();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    range.push_back(named_colour("p", parts[i], "var(--c" + std::to_string(i % kColours + 1) + ")"));
  }
  return range;
}

ordered_json base(const ordered_json& rows) {
  return {
      {"width", "container"}, {"autosize", {{"type", "fit-x"}, {"contains", "padding"}}}, {"data", {{"values", rows}}}};
}

ordered_json quantity(const std::string& field, const std::string& title) {
  return {{"field", field}, {"type", "quantitative"}, {"title", title}};
}

/// An axis whose labels have a prefix by size: "20 mJ".
ordered_json si_axis(const std::string& unit) {
  ordered_json axis = {{"format", "~s"}};
  if (!unit.empty()) axis["labelExpr"] = "replace(datum.label, /([a-zA-Zµ]?)$/, ' $1') + '" + unit + "'";
  return axis;
}

/// Names of values on one line of a chart, of those that would cover each other one: "8, 16". low, high: ends of the
/// axis.
ordered_json joined_names(const ordered_json& rows, const std::string& parameter, double low, double high) {
  constexpr double kLetter = 0.03;  // width of a letter over that of the axis, of two charts side by side
  struct Name {
    double at;  ///< 0 to 1
    std::string text;
    double width() const { return kLetter * static_cast<double>(text.size() + 1); }
  };
  std::vector<Name> sorted, found;
  for (const ordered_json& row : rows) {
    if (row.at("parameter") != parameter) continue;
    sorted.push_back({(row.at("factor").get<double>() - low) / (high - low), row.at("value").get<std::string>()});
  }
  std::ranges::stable_sort(sorted, {}, &Name::at);
  for (Name name : sorted) {
    while (!found.empty() && name.at - found.back().at < 0.5 * (name.width() + found.back().width())) {
      name = {0.5 * (name.at + found.back().at), found.back().text + ", " + name.text};
      found.pop_back();
    }
    found.push_back(name);
  }
  ordered_json names = ordered_json::array();
  for (const Name& name : found) {
    const char* side = name.at < 0.5 * name.width() ? "left" : name.at > 1.0 - 0.5 * name.width() ? "right" : "center";
    names.push_back(
        {{"parameter", parameter}, {"factor", low + name.at * (high - low)}, {"value", name.text}, {"side", side}});
  }
  return names;
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

std::string design_colour(const std::string& design) { return named_colour("d", design, "var(--c10)"); }

ordered_json stacked_bars(const ordered_json& rows, const std::vector<std::string>& parts,
                          const std::string& value_title, const std::string& unit, const std::string& part_title) {
  ordered_json spec = base(rows);
  std::set<std::string> bars;
  for (const ordered_json& row : rows) bars.insert(row.at("label").get<std::string>());
  spec["height"] = kBarPixels * bars.size();
  // Of each bar's own sum at the reader's choice: a small bar beside a large one is a sliver.
  spec["params"] = {
      {{"name", "own"}, {"value", false}, {"bind", {{"input", "checkbox"}, {"name", "each bar as 100 % "}}}}};
  spec["transform"] = {{{"calculate", "indexof(" + json_text(ordered_json(parts)) + ", datum.part)"}, {"as", "place"}},
                       {{"calculate", "own ? datum.share : datum.value"}, {"as", "drawn"}}};
  spec["mark"] = {{"type", "bar"}};
  ordered_json x = quantity("drawn", value_title);
  x["stack"] = "zero";
  x["axis"] = si_axis(unit);
  const std::string label = x["axis"].contains("labelExpr") ? x["axis"]["labelExpr"].get<std::string>() : "datum.label";
  x["axis"]["labelExpr"] = "own ? format(datum.value, '.0%') : " + label;
  spec["encoding"] = {
      {"y",
       {{"field", "label"}, {"type", "nominal"}, {"title", nullptr}, {"sort", {{"field", "order"}, {"op", "min"}}}}},
      {"x", x},
      {"color",
       {{"field", "part"},
        {"type", "nominal"},
        {"scale", {{"domain", parts}, {"range", part_palette(parts)}}},
        {"legend", {{"title", nullptr}, {"orient", "bottom"}}}}},
      {"order", {{"field", "place"}}},
      {"tooltip",
       {{{"field", "label"}, {"title", "of"}},
        {{"field", "part"}, {"title", part_title}},
        {{"field", "shown"}, {"title", value_title}},
        {{"field", "share"}, {"type", "quantitative"}, {"title", "share"}, {"format", ".1%"}}}}};
  return spec;
}

ordered_json ratio_bars(const ordered_json& rows, const ordered_json& paper, const std::vector<std::string>& labels,
                        const std::vector<std::string>& series, const std::string& value_title, SeriesColours colours) {
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
      {"scale", {{"domain", series}, {"range", colours == SeriesColours::machines ? palette("m", 4) : palette()}}},
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
  spec["layer"] = ordered_json::array({bars});
  if (!paper.empty()) spec["layer"].push_back(ticks);
  return spec;
}

ordered_json waterfall(const ordered_json& rows, const std::string& value_title) {
  ordered_json spec = base(rows);
  spec["height"] = kBarPixels * rows.size();
  spec["mark"] = {{"type", "bar"}};
  ordered_json x = quantity("before", value_title);
  x["axis"] = {{"labelExpr", "abs(datum.value) < 1000 ? format(datum.value, '.4~r') : format(datum.value, '.3~s')"}};
  spec["encoding"] = {
      {"y",
       {{"field", "label"}, {"type", "nominal"}, {"title", nullptr}, {"sort", {{"field", "order"}, {"op", "min"}}}}},
      {"x", x},
      {"x2", {{"field", "after"}}},
      {"color",
       {{"field", "change"},
        {"type", "nominal"},
        {"scale", {{"domain", {"whole", "gain", "loss"}}, {"range", {"var(--c8)", "var(--c3)", "var(--c4)"}}}},
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
  double low = 1.0, high = 1.0;
  for (const ordered_json& row : rows) {
    low = std::min(low, row.at("factor").get<double>());
    high = std::max(high, row.at("factor").get<double>());
  }
  const double margin = high > low ? 0.06 * (high - low) : 0.1;
  low -= margin;
  high += margin;
  ordered_json names = ordered_json::array();
  for (const std::string& parameter : parameters) {
    for (ordered_json& name : joined_names(rows, parameter, low, high)) names.push_back(std::move(name));
  }
  ordered_json x = quantity("factor", factor_title);
  x["scale"] = {{"zero", false}, {"nice", false}, {"domain", {low, high}}};
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
  words["data"] = {{"values", names}};
  words["mark"] = {{"type", "text"}, {"dy", -10}, {"fontSize", 11}, {"align", {{"expr", "datum.side"}}}};
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
  const double margin = std::pow(high / low, 0.05);
  const auto axis = [&](const char* field) {
    ordered_json q = quantity(field, field);
    q["scale"] = {{"type", "log"}, {"nice", false}, {"domain", {low / margin, high * margin}}};
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
  ordered_json labels;
  labels["mark"] = {{"type", "text"}, {"align", "left"}, {"dx", 7}, {"dy", -7}};
  labels["encoding"] = {
      {"x", axis("measured")}, {"y", axis("simulated")}, {"text", {{"field", "number"}, {"type", "nominal"}}}};
  spec["layer"] =
      ordered_json::array({same, rule("measured", "simulated"), rule("simulated", "measured"), points, labels});
  return spec;
}

ordered_json series_lines(const ordered_json& rows, const std::string& value_title,
                          const std::vector<std::string>& designs) {
  const bool several = designs.size() > 1;
  ordered_json spec = base(rows);
  spec["height"] = 160;
  spec["mark"] = {{"type", "line"}, {"interpolate", "step-before"}};
  ordered_json x = several ? quantity("part", "of the design's cycles") : quantity("cycle", "core cycle");
  x["axis"] = {{"format", several ? "%" : "~s"}};
  ordered_json range = ordered_json::array();
  for (const std::string& design : designs) range.push_back(design_colour(design));
  spec["encoding"] = {{"x", x},
                      {"y", quantity("value", value_title)},
                      {"color",
                       {{"field", "series"},
                        {"type", "nominal"},
                        {"scale", {{"domain", designs}, {"range", range}}},
                        {"legend", several ? ordered_json{{"title", nullptr},
                                                          {"orient", "bottom"},
                                                          {"symbolType", "stroke"},
                                                          {"symbolStrokeWidth", 3}}
                                           : ordered_json(nullptr)}}},
                      {"tooltip",
                       {{{"field", "series"}},
                        {{"field", "cycle"}, {"type", "quantitative"}},
                        {{"field", "value"}, {"type", "quantitative"}}}}};
  return spec;
}

}  // namespace grtx::report
