// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/simulate_designs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <numeric>
#include <optional>
#include <thread>
#include <vector>

#include "grtx/base/child_process.h"
#include "grtx/base/free_memory.h"
#include "grtx/base/json.h"
#include "grtx/experiment/design_progress.h"
#include "grtx/experiment/simulate_mode.h"
#include "grtx/explore/cost/energy_statistics.h"
#include "grtx/rtl_tlm/estimate/windows/window_refusal.h"
#include "grtx/rtl_tlm/run/simulation.h"
#include "grtx/rtl_tlm/run/trace_source.h"
#include "grtx/traces/reader.h"

namespace grtx::experiment {
namespace {

/// Memory of the largest simulation.
std::uint64_t largest_simulation(const std::map<std::string, TracedDesign>& traced, const sim::GpuConfig& config) {
  std::uint64_t groups = 0;
  for (const auto& [name, design] : traced) {
    const std::uint64_t resident = std::uint64_t{config.sms} * config.resident() * design.file.largest_group;
    groups = std::max(groups, std::min(design.file.decoded_bytes, resident + sim::kDecodeAheadBytes));
  }
  return kMachineBytes + groups;
}

/// Number of parallel simulations: one per core, fewer if free memory does not suffice.
unsigned default_jobs(std::uint64_t bytes_each) {
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  const std::optional<std::uint64_t> free = free_memory();
  return !free ? cores : static_cast<unsigned>(std::clamp<std::uint64_t>(*free / bytes_each, 1, cores));
}

/// The report of a child process on its design.
std::string simulated_text(const std::string& trace, const sim::GpuConfig& config, const DesignSimulation& asked,
                           modules::WarpObserver* observer) {
  sim::SimulationOptions simulation;
  simulation.observer = observer;
  simulation.latency = asked.latency;
  simulation.price = explore::describe_energy;
  const sim::SimulationResult result = simulate_in_mode(asked.mode, trace, config, simulation, asked.windows).result;
  nlohmann::ordered_json document = result.document;
  document["violations"] = result.violations;
  document["binding_bound"] = result.binding_bound;
  return json_text(document);
}

}  // namespace

sim::SimulationMode unnamed_mode(const std::vector<MachineSimulation>& machines, const DesignComparison& comparison,
                                 const sim::WindowOptions& windows) {
  for (const MachineSimulation& on : machines) {
    const traces::Reader reader(on.traced->designs.at(comparison.reference()).path);
    if (!sim::windows_pay(reader, on.machine, windows)) return sim::SimulationMode::cycle;
  }
  const traces::Reader reader(machines.front().traced->designs.at(comparison.reference()).path);
  fmt::print(stderr,
             "grtx: run: {} warps with {:.0f} M node visits: estimated from windows, with intervals; --mode cycle "
             "simulates all of them\n",
             reader.group_count(), static_cast<double>(reader.totals().visits()) * 1e-6);
  return sim::SimulationMode::windows;
}

std::vector<std::map<std::string, nlohmann::ordered_json>> simulate_designs(
    const std::vector<MachineSimulation>& machines, const DesignComparison& comparison,
    const DesignSimulation& simulation) {
  struct Run {  // of a design on a machine
    std::size_t machine;
    std::string design;
    const TracedDesign* traced;
    const sim::GpuConfig* config;
  };
  std::vector<Run> runs;
  std::vector<std::string> names;
  std::vector<std::uint64_t> warps;
  std::uint64_t visits = 0, bytes_each = 0;
  for (const MachineSimulation& on : machines) {
    bytes_each = std::max(bytes_each, largest_simulation(on.traced->designs, on.configs.begin()->second));
    for (const ComparedDesign& design : comparison.designs()) {
      const Run& run = runs.emplace_back(Run{static_cast<std::size_t>(&on - machines.data()), design.name,
                                             &on.traced->designs.at(design.name), &on.configs.at(design.name)});
      names.push_back(design.name + (on.name.empty() ? "" : " on " + on.name));
      warps.push_back(traces::Reader(run.traced->path).group_count());
      visits += run.traced->file.visits;
    }
  }
  const unsigned jobs = simulation.jobs == 0 ? default_jobs(bytes_each) : simulation.jobs;
  if (!simulation.quiet) {
    const unsigned at_a_time = std::min<unsigned>(jobs, static_cast<unsigned>(runs.size()));
    say_simulation_time("run", simulation.mode, visits, simulation.windows.share, bytes_each * at_a_time, at_a_time);
  }
  DesignProgress progress(names, warps, simulation.quiet);
  // The longest first: one that is begun last is alone at the end.
  std::vector<std::size_t> order(runs.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::greater(), [&](std::size_t index) { return runs[index].traced->file.visits; });
  std::vector<ChildTask> tasks;
  for (const std::size_t index : order) {
    tasks.push_back({names[index], [&, index] {
                       return simulated_text(runs[index].traced->path, *runs[index].config, simulation,
                                             progress.observer(index));
                     }});
  }
  std::vector<std::map<std::string, nlohmann::ordered_json>> documents(machines.size());
  run_children(
      tasks, jobs,
      [&](std::size_t task, const std::string& text) {
        const Run& run = runs[order[task]];
        documents[run.machine][run.design] = parse_json(text, tasks[task].name);
      },
      [&] { progress.look(); });
  return documents;
}

}  // namespace grtx::experiment
