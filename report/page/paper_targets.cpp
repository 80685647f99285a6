// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/page/paper_targets.h"

#include <toml++/toml.h>
#include <limits>
#include <stdexcept>

#include "grtx/report/page/assets.h"

namespace grtx::report {
namespace {

// The file is built into the program, so errors in it are internal errors.
toml::table targets() { return toml::parse(paper_targets_text(), std::string_view("paper_targets.toml")); }

template <typename T>
T must(const toml::table& table, const char* key) {
  const auto value = table[key].value<T>();
  if (!value) throw std::logic_error(std::string("paper_targets.toml: a target lacks ") + key);
  return *value;
}

double bytes_of(const std::string& unit) {
  if (unit == "B") return 1.0;
  if (unit == "MiB") return 1024.0 * 1024.0;
  if (unit == "GiB") return 1024.0 * 1024.0 * 1024.0;
  throw std::logic_error("paper_targets.toml: unknown unit " + unit);
}

std::vector<RunTarget> read_run_targets() {
  std::vector<RunTarget> list;
  const toml::table file = targets();
  for (const toml::node& node : *file["run"].as_array()) {
    const toml::table& table = *node.as_table();
    list.push_back({must<std::string>(table, "name"), must<double>(table, "paper"), table["at_least"].value_or(false),
                    must<std::string>(table, "source"), must<std::string>(table, "statistic"),
                    table["over"].value_or(std::string()), must<std::string>(table, "of")});
  }
  return list;
}

std::vector<CostTarget> read_cost_targets() {
  std::vector<CostTarget> list;
  const toml::table file = targets();
  for (const toml::node& node : *file["cost"].as_array()) {
    const toml::table& table = *node.as_table();
    list.push_back({must<std::string>(table, "name"), must<double>(table, "paper"), must<std::string>(table, "unit"),
                    must<std::string>(table, "source"), must<std::string>(table, "figure"),
                    static_cast<unsigned>(table["sms"].value_or(0))});
  }
  return list;
}

}  // namespace

double RunTarget::of_run(const RunResults& run) const {
  const DesignResult* own = run.design(of);
  if (own == nullptr) return std::numeric_limits<double>::quiet_NaN();
  if (!ratio()) return own->value(statistic);
  const DesignResult* other = run.design(over);
  return other == nullptr ? std::numeric_limits<double>::quiet_NaN() : other->value(statistic) / own->value(statistic);
}

double CostTarget::of_machine(const nlohmann::ordered_json& cost) const {
  if (figure == "checkpoint_storage") return cost.at("checkpoint_storage").at("bytes").get<double>() / bytes_of(unit);
  if (figure != "buffers") throw std::logic_error("paper_targets.toml: unknown figure " + figure);
  const nlohmann::ordered_json& buffers = cost.at("buffers");
  const double per_sm = buffers.at("bytes").get<double>() / cost.at("config").at("gpu.sms").get<double>();
  return per_sm * sms / bytes_of(unit);
}

unsigned paper_k() {
  static const unsigned k = must<unsigned>(targets(), "k");
  return k;
}

std::string other_k(const RunTarget& target, const RunResults& run) {
  if (!target.statistic.starts_with("gpu.")) return "";
  std::string text;
  bool other = false;
  for (const std::string& name : {target.of, target.over}) {
    const DesignResult* design = run.design(name);
    if (design == nullptr) continue;
    const std::string k = design->subject.setting("k");
    other = other || (!k.empty() && k != std::to_string(paper_k()));
    text += (text.empty() ? "k = " : " over ") + k;
  }
  return other ? text : "";
}

const std::vector<RunTarget>& run_targets() {
  static const std::vector<RunTarget> list = read_run_targets();
  return list;
}

const std::vector<CostTarget>& cost_targets() {
  static const std::vector<CostTarget> list = read_cost_targets();
  return list;
}

}  // namespace grtx::report
