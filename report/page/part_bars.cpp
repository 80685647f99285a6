// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/page/part_bars.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "grtx/report/page/charts.h"
#include "grtx/report/page/html.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kMostParts = 11;  // besides "other"

double sum_of(const Bar& bar) {
  double sum = 0.0;
  for (const Part& part : bar.parts) sum += part.value;
  return sum;
}

std::string shown(double value, const std::string& unit) {
  return unit.empty() ? number(value < 100.0 ? value : std::round(value)) : with_unit(value, unit);
}

/// All parts that have a value, in order of appearance, with their sums over the bars.
std::vector<Part> sums_of(const std::vector<Bar>& bars) {
  std::vector<Part> sums;
  for (const Bar& bar : bars) {
    for (const Part& part : bar.parts) {
      const auto known = std::find_if(sums.begin(), sums.end(), [&](const Part& s) { return s.name == part.name; });
      if (known == sums.end()) {
        sums.push_back(part);
      } else {
        known->value += part.value;
      }
    }
  }
  std::erase_if(sums, [](const Part& s) { return !(s.value > 0.0); });
  return sums;
}

/// Names of the parts to show; if there are too many, the smallest of each bar are joined.
std::vector<std::string> join_small_parts(std::vector<Bar>& bars) {
  const std::vector<Part> sums = sums_of(bars);
  std::vector<std::string> names;
  if (sums.size() <= kMostParts) {
    for (const Part& s : sums) names.push_back(s.name);
    return names;
  }
  std::vector<double> sizes;
  for (const Part& s : sums) sizes.push_back(s.value);
  const auto last = sizes.begin() + static_cast<std::ptrdiff_t>(kMostParts) - 1;
  std::nth_element(sizes.begin(), last, sizes.end(), std::greater<>());
  const double least = *last;
  for (const Part& s : sums) {
    if (s.value > least) names.push_back(s.name);
  }
  for (Bar& bar : bars) {
    std::vector<Part> kept;
    Part other{"other", 0.0};
    for (const Part& part : bar.parts) {
      if (std::find(names.begin(), names.end(), part.name) != names.end()) {
        kept.push_back(part);
      } else {
        other.value += part.value;
      }
    }
    kept.push_back(other);
    bar.parts = std::move(kept);
  }
  names.push_back("other");
  return names;
}

std::string chart_of(const BarWords& words, const std::vector<Bar>& bars, const std::vector<std::string>& names) {
  ordered_json rows = ordered_json::array();
  for (std::size_t b = 0; b < bars.size(); ++b) {
    const double sum = sum_of(bars[b]);
    for (const Part& part : bars[b].parts) {
      if (!(part.value > 0.0)) continue;
      rows.push_back({{"label", bars[b].label},
                      {"order", b},
                      {"part", part.name},
                      {"value", part.value},
                      {"shown", shown(part.value, words.unit)},
                      {"share", part.value / sum}});
    }
  }
  return chart(words.id, words.caption, words.caption,
               stacked_bars(rows, names, words.value_title, words.unit, words.part_title));
}

std::string table_of(const BarWords& words, const std::vector<Bar>& bars, const std::vector<std::string>& names) {
  std::vector<Table::Column> columns = {{words.part_title, false}};
  for (const Bar& bar : bars) columns.push_back({bar.label});
  Table table(words.caption, columns);
  for (const std::string& name : names) {
    std::vector<std::string> cells = {escape(name)};
    for (const Bar& bar : bars) {
      const auto part = std::find_if(bar.parts.begin(), bar.parts.end(), [&](const Part& p) { return p.name == name; });
      const bool has = part != bar.parts.end() && part->value > 0.0;
      cells.push_back(!has ? ""
                           : fmt::format("{} <span class=\"share\">{}</span>", shown(part->value, words.unit),
                                         share_text(part->value / sum_of(bar))));
    }
    table.row(cells);
  }
  std::vector<std::string> cells = {"sum"};
  for (const Bar& bar : bars) cells.push_back(shown(sum_of(bar), words.unit));
  table.row(cells, " class=\"sum\"");
  return table.html();
}

}  // namespace

std::string bars_chart(const BarWords& words, std::vector<Bar> bars) {
  std::erase_if(bars, [](const Bar& bar) { return !(sum_of(bar) > 0.0); });
  if (bars.empty()) return "";
  const std::vector<std::string> names = join_small_parts(bars);
  return chart_of(words, bars, names);
}

std::string bars_html(const BarWords& words, std::vector<Bar> bars) {
  std::erase_if(bars, [](const Bar& bar) { return !(sum_of(bar) > 0.0); });
  if (bars.empty()) return "";
  const std::vector<std::string> names = join_small_parts(bars);
  return chart_of(words, bars, names) + details("The same as a table", table_of(words, bars, names));
}

}  // namespace grtx::report
