// SPDX-License-Identifier: Apache-2.0
#include "grtx/apps/grtx/energy_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "grtx/apps/grtx/results_file.h"
#include "grtx/base/child_process.h"
#include "grtx/base/json.h"
#include "grtx/explore/cost/cost_report.h"
#include "grtx/explore/cost/run_machine.h"
#include "grtx/explore/sweep/points.h"
#include "grtx/report/page/run_results.h"
#include "grtx/rtl_tlm/gpu/machine.h"

namespace grtx::apps {
namespace {

using nlohmann::ordered_json;

/// In a child process: a process elaborates one machine.
ordered_json energy_of(const ordered_json& run, const std::string& path, const explore::CostOptions& cost,
                       const explore::EnergyOptions& energy) {
  ChildProcess child("energy", [&] {
    const sim::GpuConfig config = explore::config_from(run.at("config"));
    const ordered_json& stats = run.at("stats");
    const auto value = [&stats](const std::string& name) {
      const auto found = stats.find(name);
      const bool counted = found != stats.end() && found->at("value").is_number();
      return counted ? std::optional(found->at("value").get<double>()) : std::nullopt;
    };
    const std::vector<explore::EnergyPart> parts = explore::run_energy(
        value, config, sim::machine_inventory(config, explore::machine_of_run(run.at("inputs"), path)), cost, energy,
        path);
    return json_text(explore::energy_json(parts, report::frames_of(stats)));
  });
  return parse_json(child.result(), "energy");
}

double central_uj(const ordered_json& nanojoules) { return 1e-3 * nanojoules.at("central").get<double>(); }

}  // namespace

ordered_json energies_of(const ordered_json& results, const std::string& path, const std::string& machine,
                         const explore::CostOptions& cost, const explore::EnergyOptions& energy) {
  ordered_json runs = ordered_json::array();
  for (const auto& [name, designs] : runs_of(results, path, machine)) {
    for (const std::string& design : designs) {
      ordered_json own = {{"machine", name}, {"design", design}};
      own.update(energy_of(statistics_of(results, path, design, name), path, cost, energy));
      own.erase("schema");
      runs.push_back(std::move(own));
    }
  }
  return runs;
}

std::string energies_text(const ordered_json& runs) {
  std::vector<std::string> machines, parts;
  const auto add = [](std::vector<std::string>& list, const std::string& name) {
    if (std::ranges::find(list, name) == list.end()) list.push_back(name);
  };
  for (const ordered_json& run : runs) {
    add(machines, run.at("machine"));
    for (const ordered_json& part : run.at("parts")) add(parts, part.at("part"));
  }
  const std::size_t frames = runs.empty() ? 1 : runs.front().at("frames").get<std::size_t>();  // of all designs alike
  std::string out;
  for (const std::string& machine : machines) {
    std::string head, sums, of_frame;
    std::vector<std::string> rows(parts.size());
    for (const ordered_json& run : runs) {
      if (run.at("machine") != machine) continue;
      head += fmt::format(" {:>11}", run.at("design").get<std::string>());
      sums += fmt::format(" {:>11.2f}", central_uj(run.at("run_nanojoules")));
      of_frame += fmt::format(" {:>11.2f}", central_uj(run.at("frame_nanojoules")));
      for (std::size_t i = 0; i < parts.size(); ++i) {
        const auto own = std::ranges::find_if(run.at("parts"), [&](const auto& p) { return p.at("part") == parts[i]; });
        rows[i] += own == run.at("parts").end() ? fmt::format(" {:>11}", "")
                                                : fmt::format(" {:>11.2f}", central_uj(own->at("nanojoules")));
      }
    }
    out +=
        fmt::format("{}energy on {}, uJ, central estimate\n{:<20}{}\n", out.empty() ? "" : "\n", machine, "part", head);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (rows[i].find_first_not_of(' ') != std::string::npos) out += fmt::format("{:<20}{}\n", parts[i], rows[i]);
    }
    out += fmt::format("{:<20}{}\n", "run", sums);
    if (frames > 1) out += fmt::format("{:<20}{}\n", report::frame_text(frames), of_frame);
  }
  return out;
}

std::string energies_csv(const ordered_json& runs) {
  std::string out = "machine,design,part,actions,nj_low,nj_central,nj_high,action\n";
  for (const ordered_json& run : runs) {
    for (const ordered_json& part : run.at("parts")) {
      const ordered_json& nj = part.at("nanojoules");
      out += fmt::format("\"{}\",{},{},{},{},{},{},\"{}\"\n", run.at("machine").get<std::string>(),
                         run.at("design").get<std::string>(), part.at("part").get<std::string>(),
                         part.at("actions").get<double>(), nj.at("low").get<double>(), nj.at("central").get<double>(),
                         nj.at("high").get<double>(), part.at("action").get<std::string>());
    }
  }
  return out;
}

}  // namespace grtx::apps
