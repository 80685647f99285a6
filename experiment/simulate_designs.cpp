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

/// What a child process reports for its design.
std::string simulated_text(const std::string& trace, const sim::GpuConfig& config, const DesignSimulation& asked,
                           modules::WarpObserver* observer) {
  sim::SimulationOptions simulation;
  simulation.observer = observer;
  simulation.price = explore::describe_energy;
  const sim::SimulationResult result = simulate_in_mode(asked.mode, trace, config, simulation, asked.windows).result;
  nlohmann::ordered_json document = result.document;
  document["violations"] = result.violations;
  document["binding_bound"] = result.binding_bound;
  return json_text(document);
}

}  // namespace

sim::SimulationMode unnamed_mode(const TracedDesigns& traced, const DesignComparison& comparison,
                                 const sim::GpuConfig& config, const sim::WindowOptions& windows) {
  const traces::Reader reader(traced.designs.at(comparison.reference()).path);
  if (!sim::windows_pay(reader, config, windows)) return sim::SimulationMode::cycle;
  fmt::print(stderr,
             "grtx: run: {} warps with {:.0f} M node visits: estimated from windows, with intervals; --mode cycle "
             "simulates all of them\n",
             reader.group_count(), static_cast<double>(reader.totals().visits()) * 1e-6);
  return sim::SimulationMode::windows;
}

std::map<std::string, nlohmann::ordered_json> simulate_designs(const TracedDesigns& traced,
                                                               const DesignComparison& comparison,
                                                               const DesignSimulation& simulation) {
  const std::uint64_t bytes_each = largest_simulation(traced.designs, simulation.configs.begin()->second);
  const unsigned jobs = simulation.jobs == 0 ? default_jobs(bytes_each) : simulation.jobs;
  std::map<std::string, nlohmann::ordered_json> documents;
  std::vector<std::string> names;
  std::vector<std::uint64_t> warps;
  for (const ComparedDesign& design : comparison.designs()) {
    names.push_back(design.name);
    warps.push_back(traces::Reader(traced.designs.at(design.name).path).group_count());
  }
  std::uint64_t visits = 0;
  for (const auto& [name, design] : traced.designs) visits += design.file.visits;
  if (!simulation.quiet) {
    const unsigned at_a_time = std::min<unsigned>(jobs, static_cast<unsigned>(names.size()));
    say_simulation_time("run", simulation.mode, visits, simulation.windows.share, bytes_each * at_a_time, at_a_time);
  }
  DesignProgress progress(names, warps, simulation.quiet);
  // The longest first: one that is begun last is alone at the end.
  std::vector<std::size_t> order(names.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto visits_of = [&](std::size_t index) { return traced.designs.at(names[index]).file.visits; };
  std::ranges::stable_sort(order, std::greater(), visits_of);
  std::vector<ChildTask> tasks;
  for (const std::size_t index : order) {
    tasks.push_back({names[index], [&, index] {
                       const std::string& name = names[index];
                       return simulated_text(traced.designs.at(name).path, simulation.configs.at(name), simulation,
                                             progress.observer(index));
                     }});
  }
  run_children(
      tasks, jobs,
      [&](std::size_t task, const std::string& text) {
        documents[tasks[task].name] = parse_json(text, tasks[task].name);
      },
      [&] { progress.look(); });
  return documents;
}

}  // namespace grtx::experiment
