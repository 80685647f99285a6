// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/regress/regression.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <future>
#include <memory>
#include <optional>
#include <stdexcept>

#include "grtx/base/atomic_file.h"
#include "grtx/base/child_process.h"
#include "grtx/base/error.h"
#include "grtx/base/json.h"
#include "grtx/base/stopwatch.h"
#include "grtx/rtl_tlm/estimate/windows/window_simulation.h"
#include "grtx/rtl_tlm/run/statistics_table.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;
using Kind = RegressionOutcome::Kind;

GpuConfig machine_of(const RegressionCase& c, const RegressionOptions& options) {
  try {
    std::vector<std::string> settings;
    if (!c.design.empty()) {
      if (!options.design_keys) throw Error(c.file, "design", "is not known to this program: set its keys");
      settings = options.design_keys(c);
    }
    settings.insert(settings.end(), c.settings.begin(), c.settings.end());
    if (options.machine) return options.machine(c.machine, c.config, settings);
    if (!c.machine.empty()) throw Error(c.file, "machine", "is not known to this program: name a configuration");
    return load_config(c.config, settings);
  } catch (const Error& error) {
    if (error.file() != "--set") throw;
    // The error is about the option --set, which here is a line of the case.
    std::string place = "set";
    for (const RegressionSetting& setting : c.setting_places) {
      if (setting.text == error.place() || setting.text.starts_with(error.place() + "=")) place = setting.place;
    }
    throw Error(c.file, place, fmt::format("set: {}: {}", error.place(), error.rule()));
  }
}

/// Throws Error for a pattern of the case that matches no name.
void check_patterns(const RegressionCase& c, const std::vector<std::string>& names) {
  const auto is_used = [&](const std::string& pattern) {
    return std::any_of(names.begin(), names.end(),
                       [&](const std::string& name) { return matches_pattern(pattern, name); });
  };
  for (const std::string& pattern : c.statistics) {
    if (!is_used(pattern)) throw Error(c.file, "statistics", fmt::format("'{}' is the name of none", pattern));
  }
  for (const RegressionTolerance& tolerance : c.tolerances) {
    if (is_used(tolerance.pattern)) continue;
    throw Error(c.file, tolerance.place, fmt::format("tolerance: '{}' fits none that is compared", tolerance.pattern));
  }
}

/// Runs a case in its child process. Returns the text that is sent back to the parent.
std::string run_case(const RegressionCase& c, const RegressionOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const GpuConfig config = machine_of(c, options);
  if (options.reason.empty() && !StatisticsTable(c.record).has(c.column)) {
    const std::string cases = options.cases == "*" ? "" : " --cases '" + options.cases + "'";
    throw Error(c.record, "case '" + c.column + "'",
                fmt::format("there is no record yet, and the case was not run; to make one: grtx regress {}{} --update "
                            "--reason TEXT",
                            options.folder, cases));
  }
  const SimulationResult result =
      options.simulate ? options.simulate(c, config) : simulate_case(c, config, options.price);
  ordered_json stats = ordered_json::object();
  for (const auto& [name, statistic] : result.document.at("stats").items()) {
    if (is_compared(c, name)) stats[name] = statistic;
  }
  const ordered_json document = {{"schema", result.document.at("schema")},
                                 {"config", result.document.at("config")},
                                 {"inputs", result.document.at("inputs")},
                                 {"stats", std::move(stats)}};
  return json_text(
      ordered_json{{"document", document}, {"violations", result.violations}, {"seconds", seconds_since(start)}});
}

/// A case's column of records.tsv: statistics by name, and the keys config.* and inputs.*.
ordered_json column_of(const ordered_json& document) {
  ordered_json values = ordered_json::object();
  for (const char* part : {"config", "inputs"}) {
    for (const auto& [key, value] : document.at(part).items()) values[fmt::format("{}.{}", part, key)] = value;
  }
  for (const auto& [name, statistic] : document.at("stats").items()) values[name] = statistic.at("value");
  return values;
}

/// The inverse of column_of().
ordered_json document_of(const ordered_json& column) {
  ordered_json document = {{"config", ordered_json::object()}, {"inputs", ordered_json::object()}};
  ordered_json& stats = document["stats"] = ordered_json::object();
  for (const auto& [name, value] : column.items()) {
    if (name.starts_with("config.")) {
      document["config"][name.substr(7)] = value;
    } else if (name.starts_with("inputs.")) {
      document["inputs"][name.substr(7)] = value;
    } else {
      stats[name] = {{"value", value}};
    }
  }
  return document;
}

/// Compares a case's run with its record and sets the outcome; with a reason, writes the record. Throws Error.
void judge(RegressionOutcome& outcome, const ordered_json& found, const RegressionOptions& options) {
  const RegressionCase& c = outcome.regression_case;
  outcome.seconds = found.at("seconds").get<double>();
  const ordered_json& document = found.at("document");
  if (document.at("stats").empty()) throw Error(c.file, "statistics", "name none that this simulation has");
  if (const ordered_json& violations = found.at("violations"); !violations.empty()) {
    outcome.kind = Kind::differs;
    outcome.message = "conservation law violated: " + violations.front().get<std::string>();
    return;
  }
  StatisticsTable records(c.record);
  const bool is_new = !records.has(c.column);
  const ordered_json record = is_new ? document : document_of(records.values_of(c.column));
  std::vector<std::string> names;
  for (const ordered_json& stats : {document.at("stats"), record.at("stats")}) {
    for (const auto& [name, statistic] : stats.items()) {
      if (is_compared(c, name)) names.push_back(name);
    }
  }
  check_patterns(c, names);
  if (!is_new) {
    outcome.comparison = compare_statistics(c, record, document);
    if (outcome.comparison.compared == 0 && options.reason.empty()) {
      throw Error(c.record, c.column, "holds none of the case's statistics: --update --reason TEXT records them");
    }
    const bool grown = !outcome.comparison.unrecorded.empty() && !options.reason.empty();
    if (outcome.comparison.equal() && !grown) return;
  }
  const auto& differences = outcome.comparison.differences;
  outcome.message =
      is_new ? "new" : fmt::format("{} of {} statistics differ", differences.size(), outcome.comparison.compared);
  outcome.kind = Kind::differs;
  if (options.reason.empty()) return;
  note_update(c, options.program, options.reason);  // first: a record without its reason would be lost knowledge
  records.put(c.column, column_of(document));
  write_file(c.record, records.text());
  outcome.kind = Kind::recorded;
}

/// text: of the case's child process.
RegressionOutcome outcome_of(const RegressionCase& c, std::future<std::string>& text,
                             const RegressionOptions& options) {
  RegressionOutcome outcome;
  outcome.regression_case = c;
  try {
    judge(outcome, parse_json(text.get(), "case"), options);
  } catch (const Error& error) {
    outcome.kind = Kind::refused;
    outcome.message = error.what();
  } catch (const std::runtime_error& error) {  // the model deadlocked or crashed
    outcome.kind = Kind::differs;
    outcome.message = error.what();
  }
  return outcome;
}

void print(const RegressionOutcome& outcome, const RegressionOptions& options) {
  const std::string& name = outcome.regression_case.name;
  const StatisticsComparison& comparison = outcome.comparison;
  if (outcome.kind == Kind::refused) {
    fmt::print(stderr, "grtx: regress: {}: {}\n", name, outcome.message);
    return;
  }
  if (options.silent) return;
  if (outcome.kind == Kind::equal) {
    if (options.quiet) return;
    fmt::print("{}: equal, {} statistics\n", name, comparison.compared);
  } else {
    fmt::print("{}: {}: {}\n", name, outcome_name(outcome.kind), outcome.message);
    fmt::print("{}", text_of(comparison, options.each));
  }
  if (!comparison.unrecorded.empty() && outcome.kind != Kind::recorded) {
    fmt::print("  {} statistics are not on record: {}{}\n", comparison.unrecorded.size(), comparison.unrecorded.front(),
               comparison.unrecorded.size() > 1 ? " and others" : "");
  }
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += static_cast<unsigned char>(c) < 0x20 && c != '\n' ? ' ' : c;
    }
  }
  return out;
}

std::size_t count(const std::vector<RegressionOutcome>& outcomes, Kind kind) {
  std::size_t n = 0;
  for (const RegressionOutcome& outcome : outcomes) n += outcome.kind == kind ? 1 : 0;
  return n;
}

}  // namespace

SimulationResult simulate_case(const RegressionCase& regression_case, const GpuConfig& config,
                               const EnergyPricing& price) {
  if (regression_case.mode == SimulationMode::windows) {
    WindowOptions windows = regression_case.windows;
    windows.price = price;
    return simulate_windows(regression_case.trace, config, windows).result;
  }
  SimulationOptions options;
  options.price = price;
  return simulate(regression_case.trace, config, options);
}

std::vector<RegressionOutcome> run_regression(const RegressionOptions& options) {
  std::vector<RegressionCase> cases = load_regression(options.folder);
  std::erase_if(cases,
                [&](const RegressionCase& c) { return ::fnmatch(options.cases.c_str(), c.name.c_str(), 0) != 0; });
  if (cases.empty()) throw Error(options.folder, options.cases, "is the name of no case");
  std::vector<std::unique_ptr<ChildProcess>> running;
  std::vector<std::size_t> indices;                           // of the running ones
  std::vector<std::future<std::string>> texts(cases.size());  // of those that have ended
  std::vector<RegressionOutcome> outcomes;                    // in the order of the cases, as records are written
  for (std::size_t next = 0; outcomes.size() < cases.size();) {
    while (next < cases.size() && running.size() < std::max(1U, options.jobs)) {
      const RegressionCase& c = cases[next];
      running.push_back(std::make_unique<ChildProcess>(c.name, [&] { return run_case(c, options); }));
      indices.push_back(next++);
    }
    const std::optional<std::size_t> ended = ChildProcess::wait_for_any(running, std::chrono::seconds(1));
    if (!ended) continue;
    const auto at = static_cast<std::ptrdiff_t>(*ended);
    std::packaged_task<std::string()> result([&child = *running[*ended]] { return child.result(); });
    texts[indices[*ended]] = result.get_future();
    result();
    running.erase(running.begin() + at);
    indices.erase(indices.begin() + at);
    while (outcomes.size() < next && texts[outcomes.size()].valid()) {
      const std::size_t index = outcomes.size();
      outcomes.push_back(outcome_of(cases[index], texts[index], options));
      print(outcomes.back(), options);
    }
  }
  if (!options.quiet && !options.silent) {
    fmt::print("{} cases: {} equal, {} differ, {} recorded, {} refused\n", outcomes.size(),
               count(outcomes, Kind::equal), count(outcomes, Kind::differs), count(outcomes, Kind::recorded),
               count(outcomes, Kind::refused));
  }
  if (!options.junit.empty()) write_file(options.junit, junit_xml(options.folder, outcomes, options.each));
  return outcomes;
}

const char* outcome_name(RegressionOutcome::Kind kind) {
  switch (kind) {
    case Kind::equal:
      return "equal";
    case Kind::differs:
      return "differs";
    case Kind::recorded:
      return "recorded";
    case Kind::refused:
      return "refused";
  }
  return "";
}

int exit_code(const std::vector<RegressionOutcome>& outcomes) {
  if (count(outcomes, Kind::refused) > 0) return 2;
  return count(outcomes, Kind::differs) > 0 ? 1 : 0;
}

std::string junit_xml(const std::string& suite, const std::vector<RegressionOutcome>& outcomes,
                      std::optional<std::size_t> each) {
  double seconds = 0.0;
  for (const RegressionOutcome& outcome : outcomes) seconds += outcome.seconds;
  const std::string counts = fmt::format("tests=\"{}\" failures=\"{}\" errors=\"{}\" time=\"{:.3f}\"", outcomes.size(),
                                         count(outcomes, Kind::differs), count(outcomes, Kind::refused), seconds);
  std::string xml =
      fmt::format("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites {}>\n<testsuite name=\"{}\" {}>\n", counts,
                  escaped(suite), counts);
  for (const RegressionOutcome& outcome : outcomes) {
    xml += fmt::format("<testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\">", escaped(suite),
                       escaped(outcome.regression_case.name), outcome.seconds);
    if (outcome.kind == Kind::differs || outcome.kind == Kind::refused) {
      const char* const element = outcome.kind == Kind::differs ? "failure" : "error";
      xml += fmt::format("\n<{0} message=\"{1}\">{2}</{0}>\n", element, escaped(outcome.message),
                         escaped(text_of(outcome.comparison, each)));
    }
    xml += "</testcase>\n";
  }
  return xml + "</testsuite>\n</testsuites>\n";
}

}  // namespace grtx::sim
