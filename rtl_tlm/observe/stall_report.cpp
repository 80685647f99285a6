// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/observe/stall_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "grtx/base/error.h"
#include "grtx/modules/rt_unit/rt_unit_table.h"

namespace grtx::sim {
namespace {

using Json = nlohmann::ordered_json;

double number(const Json& stats, const std::string& name) {
  const auto found = stats.find(name);
  return found != stats.end() && found->contains("value") && found->at("value").is_number()
             ? found->at("value").get<double>()
             : 0.0;
}

double sum(const StallSection& section) {
  double total = 0.0;
  for (const StallBar& bar : section.bars) total += bar.value;
  return total;
}

/// All statistics "prefix.LEAF", LEAF without dots.
StallSection section_of(const Json& stats, const std::string& prefix, const std::string& title) {
  StallSection section{title, "", 0.0, {}};
  for (const auto& [name, entry] : stats.items()) {
    if (!name.starts_with(prefix + ".") || name.find('.', prefix.size() + 1) != std::string::npos) continue;
    section.bars.push_back({name.substr(prefix.size() + 1), number(stats, name)});
    if (section.unit.empty()) section.unit = entry.value("unit", "");
  }
  return section;
}

void add_stalls(const Json& stats, std::vector<StallSection>& sections) {
  std::vector<std::string> groups;
  for (const auto& [name, entry] : stats.items()) {
    if (name.find(".stall.") == std::string::npos) continue;
    const std::string group = name.substr(0, name.rfind('.'));
    if (std::find(groups.begin(), groups.end(), group) == groups.end()) groups.push_back(group);
  }
  for (const std::string& group : groups) {
    StallSection section = section_of(stats, group, group);
    const std::string owner = group.substr(0, group.find(".stall"));
    if (group == owner + ".stall" && stats.contains(owner + ".selections")) {
      section.bars.insert(section.bars.begin(), {"issue", number(stats, owner + ".selections")});
      section.title = owner + ": every cycle of every RT scheduler";
    }
    section.whole = sum(section);
    sections.push_back(section);
  }
}

void add_units(const Json& document, std::vector<StallSection>& sections) {
  const Json& stats = document.at("stats");
  const Json config = document.value("config", Json::object());
  const double cycles = number(stats, "gpu.cycles");
  StallSection section{"gpu.rt: taken pipelines of the intersection units", "% of all their cycles", 100.0, {}};
  for (const modules::PartInfo& part : modules::part_table({}, {})) {
    if (!part.pipelines) continue;
    const std::string unit = "gpu.rt." + part.name;
    const auto count = config.find(part.pipelines->count_key);
    const auto sms = config.find("gpu.sms");
    if (count == config.end() || sms == config.end() || number(stats, unit + ".operations") == 0.0) continue;
    const double all = cycles * count->get<double>() * sms->get<double>();
    if (all > 0.0) section.bars.push_back({part.name, 100.0 * number(stats, unit + ".busy_cycles") / all});
  }
  if (!section.bars.empty()) sections.push_back(section);
}

std::string amount(double value) {
  return value == std::floor(value) ? fmt::format("{:.0f}", value) : fmt::format("{:.2f}", value);
}

}  // namespace

std::vector<StallSection> stall_sections(const nlohmann::ordered_json& document, const std::string& file) {
  if (!document.is_object() || document.value("schema", Json()) != "grtx.stats/1" || !document.contains("stats")) {
    throw Error(file, "schema", "must be grtx.stats/1: what grtx sim --stats writes");
  }
  if (!document.at("stats").is_object()) throw Error(file, "stats", "must be an object");
  const Json& stats = document.at("stats");
  std::vector<StallSection> sections;
  add_stalls(stats, sections);
  if (sections.empty()) {
    const Json inputs = document.value("inputs", Json::object());
    const bool windows = inputs.is_object() && inputs.value("mode", Json()) == "windows";
    throw Error(file, "stats",
                windows ? "are of windows, which have no stalls: simulate with --mode cycle"
                        : "has no statistic named *.stall.*");
  }
  StallSection warps = section_of(stats, "gpu.simt.warp_cycles", "gpu.simt: what the resident warps did");
  warps.whole = sum(warps);
  if (!warps.bars.empty()) sections.insert(sections.begin() + 1, warps);
  add_units(document, sections);
  // Both this and the bound `longest_warp` are of one warp.
  StallSection call{"gpu.rt: the slowest traceRay call of a warp, with waits",
                    "cycles",
                    number(stats, "gpu.cycles"),
                    {{"slowest_call", number(stats, "gpu.rt.warp_latency_max")}}};
  if (call.bars.front().value > 0.0) sections.push_back(call);
  StallSection bounds = section_of(stats, "gpu.bound", "gpu.bound: no run is shorter; longest_warp is without waits");
  std::erase_if(bounds.bars, [](const StallBar& bar) { return bar.label == "largest" || bar.label == "fraction"; });
  for (const StallBar& bar : section_of(stats, "gpu.bound.unit", "").bars) {
    bounds.bars.push_back({"unit." + bar.label, bar.value});
  }
  bounds.whole = number(stats, "gpu.cycles");
  if (!bounds.bars.empty()) sections.push_back(bounds);
  return sections;
}

std::string stall_text(const std::vector<StallSection>& sections, unsigned columns) {
  std::size_t longest = 0;
  for (const StallSection& section : sections) {
    for (const StallBar& bar : section.bars) longest = std::max(longest, bar.label.size());
  }
  std::string text;
  for (const StallSection& section : sections) {
    text += fmt::format("{}{} ({} {})\n", text.empty() ? "" : "\n", section.title, amount(section.whole), section.unit);
    for (const StallBar& bar : section.bars) {
      const double part = section.whole > 0.0 ? bar.value / section.whole : 0.0;
      const auto filled = static_cast<std::size_t>(std::lround(std::clamp(part, 0.0, 1.0) * columns));
      text += fmt::format("  {:<{}} |{:<{}}| {:5.1f} %", bar.label, longest, std::string(filled, '#'), columns,
                          100.0 * part);
      text += section.unit.starts_with('%') ? "\n" : fmt::format("  {:>12}\n", amount(bar.value));
    }
  }
  return text;
}

}  // namespace grtx::sim
