// SPDX-License-Identifier: Apache-2.0
// Machines side by side: times of each design on each machine, and the keys and options in which machines differ.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "grtx/report/page/charts.h"
#include "grtx/report/page/html.h"
#include "grtx/report/page/launch_size.h"
#include "grtx/report/page/machine_words.h"
#include "grtx/report/page/sections.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;
using Machines = std::vector<const ReportRun*>;  // of runs side by side, in the order of the page

std::string machine_of(const ReportRun& run) { return run.results.subject.setting("machine"); }

/// Designs that all of the machines ran, in the order of tables.
std::vector<std::string> designs_of(const Machines& machines) {
  std::vector<std::string> names;
  for (const DesignResult& design : machines.front()->results.designs) {
    const auto has = [&](const ReportRun* run) { return run->results.design(design.name) != nullptr; };
    if (std::all_of(machines.begin(), machines.end(), has)) names.push_back(design.name);
  }
  return names;
}

double time_of(const ReportRun& run, const std::string& design) {
  const DesignResult& own = *run.results.design(design);
  const double seconds = own.frame_seconds(), mhz = run.results.config.value("gpu.core_mhz", std::nan(""));
  return std::isfinite(seconds) ? seconds : 1e-6 * own.value("gpu.cycles") / mhz / static_cast<double>(own.frames());
}

std::string frame_text_of(const Machines& machines) {
  return frame_text(machines.front()->results.designs.front().frames());
}

/// How many times as fast a design is on a machine as on the first.
double times_as_fast(const Machines& machines, const ReportRun& on, const std::string& design) {
  return time_of(*machines.front(), design) / time_of(on, design);
}

/// Why the launch is too small to compare these machines; "" if it fills them.
std::string too_small(const Machines& machines) {
  std::vector<LaunchSize> launches;
  for (const ReportRun* run : machines) {
    const std::vector<LaunchSize> own = launch_sizes(run->results);
    launches.insert(launches.end(), own.begin(), own.end());
  }
  return too_small_text(launches, "machines");
}

/// Which design loses most from each machine, and whether the launch lets one say so.
std::string answer(const Machines& machines, const std::vector<std::string>& designs) {
  const std::string small = too_small(machines);
  std::string text;
  for (const ReportRun* run : machines) {
    if (run == machines.front()) continue;
    std::vector<std::pair<std::string, double>> times;
    for (const std::string& design : designs) times.emplace_back(design, times_as_fast(machines, *run, design));
    std::string one = loses_most_text(times, machine_of(*run), machine_of(*machines.front()));
    if (one.empty()) continue;
    one.front() = 'O';
    text += escape(one) + ". ";
  }
  if (!small.empty()) text += fmt::format("<strong class=\"bad\">Mind: {}.</strong>", escape(small));
  return text.empty() ? "" : "<p class=\"answer\">" + text + "</p>\n";
}

/// What binds a design on each machine; "" where none of them says.
std::string bounds_of(const Machines& machines, const std::string& design) {
  std::string text;
  for (const ReportRun* run : machines) {
    const std::string own = binding_text(*run->results.design(design));
    if (!own.empty()) text += (text.empty() ? "" : "; ") + machine_of(*run) + ": " + own;
  }
  return text;
}

std::string times_table(const Machines& machines, const std::vector<std::string>& designs) {
  const std::string first = machine_of(*machines.front()),
                    doubt = too_small(machines).empty() ? "" : " (too few warps)";
  std::vector<Table::Column> columns = {{"design", false}};
  std::vector<double> seconds;
  for (const ReportRun* run : machines) {
    columns.push_back({machine_of(*run) + ": time"});
    if (run != machines.front()) columns.push_back({"times as fast as on " + first + doubt});
    columns.push_back({"speed-up over " + run->results.speedup_over + " there"});
    for (const std::string& design : designs) seconds.push_back(time_of(*run, design));
  }
  columns.push_back({"what binds it", false});
  const std::vector<std::string> shown = in_one_unit(seconds, "s");
  Table table("Machines side by side: time of " + frame_text_of(machines) + ", against " + first +
                  ", and speed-ups on each machine",
              columns);
  table.stacks_when_narrow();
  for (std::size_t d = 0; d < designs.size(); ++d) {
    std::vector<std::string> cells = {escape(designs[d])};
    for (std::size_t m = 0; m < machines.size(); ++m) {
      const ReportRun& run = *machines[m];
      cells.push_back(shown[m * designs.size() + d]);
      if (m != 0) cells.push_back(times(times_as_fast(machines, run, designs[d])));
      cells.push_back(speedup_text(run, *run.results.design(designs[d])));
    }
    cells.push_back(escape(bounds_of(machines, designs[d])));
    table.row(cells);
  }
  return table.html();
}

std::string times_chart(const Machines& machines, const std::vector<std::string>& designs, std::size_t group) {
  ordered_json rows = ordered_json::array();
  std::vector<std::string> names;
  double most = 0.0;
  for (const ReportRun* run : machines) {
    for (const std::string& design : designs) most = std::max(most, time_of(*run, design));
  }
  const bool in_ms = most >= 1e-3;
  for (const ReportRun* run : machines) {
    names.push_back(machine_of(*run));
    for (const std::string& design : designs) {
      const double value = time_of(*run, design) * (in_ms ? 1e3 : 1e6);
      if (std::isfinite(value)) rows.push_back({{"label", design}, {"series", names.back()}, {"value", value}});
    }
  }
  const std::string caption = "Time of " + frame_text_of(machines) + " by design and machine; shorter is better.";
  return chart(fmt::format("machines{}_times", group), caption, caption,
               ratio_bars(rows, ordered_json::array(), designs, names, in_ms ? "time, ms" : "time, µs",
                          SeriesColours::machines));
}

/// Keys of machines, and options of the tracer, that are not the same on all.
std::string differing_keys(const Machines& machines) {
  std::vector<Table::Column> columns = {{"key", false}};
  std::vector<std::string> keys;
  for (const ReportRun* run : machines) {
    columns.push_back({machine_of(*run), false});
    for (const auto& [key, value] : run->results.config.items()) {
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
    }
  }
  Table table("Keys and options of the tracer in which the machines differ", columns);
  const auto add = [&](const std::string& name, const std::vector<std::string>& values) {
    if (std::any_of(values.begin(), values.end(), [&](const std::string& own) { return own != values.front(); })) {
      std::vector<std::string> cells = {escape(name)};
      for (const std::string& value : values) cells.push_back(escape(value));
      table.row(cells);
    }
  };
  for (const std::string& key : keys) {
    std::vector<std::string> values;
    for (const ReportRun* run : machines) {
      values.push_back(key_text(run->results.config, key));
    }
    add(key, values);
  }
  std::vector<std::string> options;
  for (const std::string& design : designs_of(machines)) {
    const Subject& first = machines.front()->results.design(design)->subject;
    for (const ReportRun* run : machines) {
      for (const Fact& fact : run->results.design(design)->subject.differences(first, MayDiffer::designs)) {
        const bool known = std::find(options.begin(), options.end(), fact.name) != options.end();
        if (known || fact.name == "machine" || run->results.config.contains(fact.name)) continue;
        options.push_back(fact.name);
        std::vector<std::string> values;
        for (const ReportRun* one : machines) values.push_back(one->results.design(design)->subject.fact(fact.name));
        add(fact.name + " (tracer)", values);
      }
    }
  }
  return details(fmt::format("{} keys and options differ", table.rows()), table.html());
}

}  // namespace

bool are_side_by_side(const ReportRun& a, const ReportRun& b) {
  if (machine_of(a) == machine_of(b)) return false;
  for (const DesignResult& design : a.results.designs) {
    const DesignResult* other = b.results.design(design.name);
    if (other == nullptr) continue;
    return design.subject.unknown().empty() && other->subject.unknown().empty() &&
           design.subject.differences(other->subject, MayDiffer::machines).empty();
  }
  return false;  // no design in common
}

std::string side_by_side_html(const std::vector<ReportRun>& runs) {
  std::vector<Machines> groups;
  for (const ReportRun& run : runs) {
    const auto fits = [&](const Machines& group) {
      return std::all_of(group.begin(), group.end(), [&](const ReportRun* one) { return are_side_by_side(*one, run); });
    };
    const auto group = std::find_if(groups.begin(), groups.end(), fits);
    if (group == groups.end()) {
      groups.push_back({&run});
    } else {
      group->push_back(&run);
    }
  }
  std::erase_if(groups, [](const Machines& group) { return group.size() < 2; });
  std::string out;
  for (const Machines& group : groups) {
    const std::vector<std::string> designs = designs_of(group);
    if (designs.empty()) continue;
    const Subject& subject = group.front()->results.subject;
    const std::string view = subject.scene() + (subject.camera().empty() ? "" : ", view " + subject.camera());
    out += fmt::format("<h3>Machines side by side{}</h3>\n", groups.size() > 1 ? ": " + escape(view) : "") +
           answer(group, designs) + times_table(group, designs) +
           times_chart(group, designs, static_cast<std::size_t>(&group - groups.data()) + 1) + differing_keys(group);
  }
  return out;
}

}  // namespace grtx::report
