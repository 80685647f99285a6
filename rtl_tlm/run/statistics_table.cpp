// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/run/statistics_table.h"

#include <fmt/format.h>

#include <filesystem>
#include <set>
#include <vector>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/json.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == at) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

}  // namespace

StatisticsTable::StatisticsTable(const std::string& path) {
  if (!std::filesystem::exists(path)) return;
  const std::vector<std::string> lines = split(read_file(path), '\n');
  const auto fail = [&path](std::size_t line, const std::string& rule) {
    throw Error(path, fmt::format("line {}", line + 1), rule);
  };
  const std::vector<std::string> names = split(lines.front(), '\t');
  if (names.size() < 2 || names.front() != "statistic") fail(0, "must be 'statistic' and the names of the runs");
  for (std::size_t i = 1; i < names.size(); ++i) {
    if (!runs_.try_emplace(names[i]).second) fail(0, fmt::format("'{}' stands twice", names[i]));
  }
  if (!lines.back().empty()) fail(lines.size() - 1, "the table is cut");
  for (std::size_t line = 1; line + 1 < lines.size(); ++line) {
    const std::vector<std::string> cells = split(lines[line], '\t');
    if (cells.size() != names.size()) fail(line, fmt::format("has {} cells of {}", cells.size(), names.size()));
    for (std::size_t i = 1; i < cells.size(); ++i) {
      if (cells[i].empty()) continue;
      const ordered_json value = parse_json(cells[i], path, fmt::format("line {}", line + 1));
      if (value.is_structured()) fail(line, fmt::format("'{}' is no value", cells[i]));
      if (!runs_[names[i]].try_emplace(cells.front(), cells[i]).second) {
        fail(line, fmt::format("'{}' stands twice", cells.front()));
      }
    }
  }
}

ordered_json StatisticsTable::values_of(const std::string& run) const {
  ordered_json values = ordered_json::object();
  for (const auto& [name, value] : runs_.at(run)) values[name] = parse_json(value, name);
  return values;
}

void StatisticsTable::put(const std::string& run, const ordered_json& values) {
  std::map<std::string, std::string>& column = runs_[run];
  column.clear();
  for (const auto& [name, value] : values.items()) column[name] = json_text(value);
}

std::string StatisticsTable::text() const {
  std::string text = "statistic";
  std::set<std::string> names;
  for (const auto& [run, values] : runs_) {
    text += '\t' + run;
    for (const auto& [name, value] : values) names.insert(name);
  }
  text += '\n';
  for (const std::string& name : names) {
    text += name;
    for (const auto& [run, values] : runs_) {
      const auto value = values.find(name);
      text += '\t' + (value == values.end() ? "" : value->second);
    }
    text += '\n';
  }
  return text;
}

}  // namespace grtx::sim
