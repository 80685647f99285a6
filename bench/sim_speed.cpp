// SPDX-License-Identifier: Apache-2.0
// How fast the simulator is, as a ratio to a fixed loop measured in the same run, so that runs on a busy or a different
// machine compare. One command measures and appends to a history file; --compare judges the last entry.
//
//   bench/sim_speed                                  a synthetic room, the four designs
//   bench/sim_speed scene.grtx --history speed.json  traces of your own
//   bench/sim_speed --compare --history speed.json   last entry of each trace against the one before
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <systemc>
#include <vector>

#include "bench/processor_time.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/child_process.h"
#include "grtx/base/error.h"
#include "grtx/base/json.h"
#include "grtx/explore/cost/energy_statistics.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/run/simulation.h"

namespace {

using nlohmann::ordered_json;

/// The yardstick: dependent reads over 1 MB with arithmetic in between, like a model whose state lies in the host's
/// second-level cache. Never change it: it would make older entries of the history meaningless. Returns seconds of CPU.
double reference_loop() {
  std::vector<std::uint32_t> next(1u << 18);
  std::uint64_t state = 1;
  for (std::uint32_t i = 0; i < next.size(); ++i) next[i] = i;
  for (std::size_t i = next.size() - 1; i > 0; --i) {  // one cycle through all (Sattolo)
    state = state * 6364136223846793005u + 1442695040888963407u;
    std::swap(next[i], next[(state >> 33) % i]);
  }
  const double start = grtx::bench::cpu_seconds(CLOCK_THREAD_CPUTIME_ID);
  std::uint32_t at = 0;
  std::uint64_t sum = 0;
  for (unsigned i = 0; i < 20'000'000; ++i) {
    at = next[at];
    sum = (sum ^ at) * 0x9E3779B97F4A7C15u;
    sum ^= sum >> 29;
  }
  const double seconds = grtx::bench::cpu_seconds(CLOCK_THREAD_CPUTIME_ID) - start;
  volatile std::uint64_t keep = sum;
  static_cast<void>(keep);
  return seconds;
}

struct Options {
  std::vector<std::string> traces;
  std::string config = std::string(GRTX_SOURCE_DIR) + "/configs/table1.toml";
  std::vector<std::string> settings;
  std::string history = "sim_speed.json";
  std::string label;
  unsigned repeats = 3;
  bool compare = false;
  double tolerance = 0.1;
};

double value(const ordered_json& stats, const char* name) { return stats.at(name).at("value").get<double>(); }

/// The statistics of one run, in a process of its own.
ordered_json simulate_once(const std::string& trace, const grtx::sim::GpuConfig& config) {
  grtx::ChildProcess child(trace, [&] {
    grtx::sim::SimulationOptions options;
    options.quiet = true;
    options.price = grtx::explore::describe_energy;
    return grtx::json_text(grtx::sim::simulate(trace, config, options).document);
  });
  return grtx::parse_json(child.result(), "simulation").at("stats");
}

/// Best of `repeats` runs: what disturbs a run only makes it slower. The loop runs before each, for the same reason.
ordered_json measure(const std::string& trace, const grtx::sim::GpuConfig& config, const Options& options) {
  double loop = 1e300;
  double seconds = 1e300;
  ordered_json stats;
  for (unsigned i = 0; i < options.repeats; ++i) {
    loop = std::min(loop, reference_loop());
    stats = simulate_once(trace, config);
    seconds = std::min(seconds, value(stats, "host.cpu_seconds"));
  }
  const double cycles = value(stats, "gpu.cycles");
  const double visits = value(stats, "gpu.rt.node_visits");
  ordered_json entry;
  entry["trace"] = std::filesystem::path(trace).filename().string();
  entry["config_hash"] = grtx::sim::config_hash(config);
  entry["label"] = options.label;
  entry["time"] = static_cast<std::int64_t>(std::time(nullptr));
  entry["cycles"] = cycles;
  entry["node_visits"] = visits;
  entry["cpu_seconds"] = seconds;
  entry["loop_seconds"] = loop;
  entry["cycles_per_second"] = cycles / seconds;
  entry["visits_per_second"] = visits / seconds;
  entry["visits_per_loop"] = visits / seconds * loop;
  return entry;
}

ordered_json read_history(const std::string& path) {
  return std::filesystem::exists(path) ? grtx::read_json(path) : ordered_json::array();
}

/// Returns whether no trace became slower than the tolerance allows.
bool compare(const Options& options) {
  std::map<std::string, std::vector<ordered_json>> by_trace;
  for (const ordered_json& entry : read_history(options.history)) {
    by_trace[entry.at("trace").get<std::string>() + ' ' + entry.at("config_hash").get<std::string>()].push_back(entry);
  }
  bool good = true;
  for (const auto& [name, entries] : by_trace) {
    if (entries.size() < 2) continue;
    const double before = entries[entries.size() - 2].at("visits_per_loop").get<double>();
    const double now = entries.back().at("visits_per_loop").get<double>();
    const bool slower = now < before * (1.0 - options.tolerance);
    good = good && !slower;
    fmt::print("{:<44} {:8.3f} x{}\n", name, now / before, slower ? "  SLOWER" : "");
  }
  return good;
}

/// Traces of a synthetic room for the four designs.
std::vector<std::string> make_traces(const std::string& folder) {
  const auto run = [&](const std::string& arguments) {
    if (std::system(("'" GRTX_PROGRAM "' " + arguments + " --quiet").c_str()) != 0) {
      throw grtx::Error("sim_speed", arguments, "the program must be able to make the trace");
    }
  };
  const std::string scene = folder + "/room.ply";
  run("synth --preset flat --count 20000 -o '" + scene + "'");
  std::vector<std::string> traces;
  for (const auto& [name, arguments] :
       std::map<std::string, std::string>{{"baseline", "--accel tri20"},
                                          {"grtx", "--accel tlas-tri20 --checkpoint on"},
                                          {"hw", "--accel tri20 --checkpoint on"},
                                          {"sw", "--accel tlas-tri20"}}) {
    traces.push_back(folder + "/room_" + name + ".grtx");
    run("trace --scene '" + scene + "' --cameras '" + folder + "/room.cameras.json' --width 64 --height 64 " +
        arguments + " -o '" + traces.back() + "'");
  }
  return traces;
}

int run(const Options& options) {
  if (options.compare) return compare(options) ? 0 : 1;
  const grtx::sim::GpuConfig config = grtx::sim::load_config(options.config, options.settings);
  std::string folder;
  std::vector<std::string> traces = options.traces;
  if (traces.empty()) {
    folder = (std::filesystem::temp_directory_path() / fmt::format("sim_speed_{}", ::getpid())).string();
    std::filesystem::create_directories(folder);
    traces = make_traces(folder);
  }
  ordered_json history = read_history(options.history);
  for (const std::string& trace : traces) {
    const ordered_json entry = measure(trace, config, options);
    fmt::print("{:<28} {:6.3f} M cycles/s  {:6.3f} M visits/s  {:9.0f} visits a loop  ({:.2f} s of CPU)\n",
               entry["trace"].get<std::string>(), entry["cycles_per_second"].get<double>() * 1e-6,
               entry["visits_per_second"].get<double>() * 1e-6, entry["visits_per_loop"].get<double>(),
               entry["cpu_seconds"].get<double>());
    std::fflush(stdout);
    history.push_back(entry);
  }
  grtx::write_file(options.history, grtx::json_text(history, 1) + "\n");
  if (!folder.empty()) std::filesystem::remove_all(folder);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  setenv("SYSTEMC_DISABLE_COPYRIGHT_MESSAGE", "1", 1);  // read by the kernel before it calls sc_main
  return sc_core::sc_elab_and_sim(argc, argv);
}

int sc_main(int argc, char* argv[]) {
  Options options;
  CLI::App app("Measures the simulator's speed against a fixed loop");
  app.add_option("TRACE", options.traces, "Traces; none: a synthetic room with the four designs");
  app.add_option("--config", options.config, "Configuration file");
  app.add_option("--set", options.settings, "key=value; repeatable")->allow_extra_args(false);
  app.add_option("--history", options.history, "JSON file to which the results are appended");
  app.add_option("--label", options.label, "Text kept with the entries, e.g. a commit");
  app.add_option("--repeats", options.repeats, "Runs a trace; the fastest counts")->check(CLI::PositiveNumber);
  app.add_flag("--compare", options.compare, "Compare the last two entries of each trace; exit code 1 if slower");
  app.add_option("--tolerance", options.tolerance, "Slowdown that --compare allows");
  CLI11_PARSE(app, argc, argv);
  try {
    return run(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "sim_speed: {}\n", error.what());
    return 2;
  }
}
