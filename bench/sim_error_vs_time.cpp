// Simulation time against error: cycle mode on one thread and on several, fast mode at several strides, sampled mode at
// several shares, over scenes and the four designs, with the coverage of sampled mode's intervals over many
// seeds. Every result is a file in the output folder and is not simulated again, so the program can
// be interrupted, and rerun with more seeds or after a change to one mode (delete its files, or its folder).
//
//   bench/sim_error_vs_time -o out --room 3000                  a generated room, traced here
//   bench/sim_error_vs_time -o out --traces playbot=FOLDER      FOLDER has baseline.grtx, sw.grtx, hw.grtx, grtx.grtx
#include <fmt/format.h>
#include <sys/wait.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <systemc>
#include <vector>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/rtl_tlm/estimate/sampled/estimate.h"
#include "grtx/rtl_tlm/run/statistics_json.h"

namespace {

using grtx::sim::ConfidenceInterval;
using grtx::sim::SampledEstimate;
using nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr std::array<const char*, 4> kDesigns = {"baseline", "sw", "hw", "grtx"};

struct Options {
  std::vector<std::string> traces;  ///< NAME=FOLDER
  unsigned room = 0;                ///< Gaussians of a generated room; 0: none
  std::string output;
  std::string config = std::string(GRTX_SOURCE_DIR) + "/configs/table1.toml";
  std::vector<std::string> shares = {"0.1"};
  std::string machine;                     ///< in place of a configuration; "": none
  std::vector<unsigned> strides = {1, 4};  ///< of fast mode
  std::vector<unsigned> threads;           ///< of cycle mode, beside one
  std::vector<std::string> engines = {"cycle"};
  unsigned seeds = 10;
  bool existing = false;  ///< simulate nothing, evaluate the seeds whose four files are there
};

const std::string& machine_of(const Options& options) {
  return options.machine.empty() ? options.config : options.machine;
}

/// A way to simulate: mode and its arguments.
struct Setting {
  std::string name, arguments;
  std::string seed;  ///< the argument before a seed; none: runs do not depend on one
  bool sampled = false;
  bool wall = false;  ///< its time is wall time: it has several threads
};

/// One run, as its statistics file says.
struct Outcome {
  double cycles = 0.0, cpu = 0.0, wall = 0.0;
  SampledEstimate estimate;
};

void run_program(const std::string& arguments) {
  const int status = std::system(("'" GRTX_PROGRAM "' " + arguments + " --quiet").c_str());
  if (status != 0) throw grtx::Error("sim_error_vs_time", arguments, "the program must be able to do this");
}

Outcome outcome_of(const std::string& path, bool sampled) {
  const ordered_json document = ordered_json::parse(grtx::read_file(path));
  const ordered_json& stats = document.at("stats");
  Outcome outcome;
  outcome.cycles = stats.at("gpu.cycles").at("value").get<double>();
  outcome.wall = stats.at("host.wall_seconds").at("value").get<double>();
  outcome.cpu = stats.at("host.cpu_seconds").at("value").get<double>();
  if (sampled) outcome.estimate = grtx::sim::estimate_from_json(document.at("sampled"));
  return outcome;
}

std::string path_of(const Options& options, const std::string& scene, const Setting& setting, const std::string& design,
                    unsigned seed) {
  const std::string suffix = setting.seed.empty() ? "" : fmt::format("_{}", seed);
  return fmt::format("{}/{}/{}/{}{}.json", options.output, scene, setting.name, design, suffix);
}

/// Simulates unless the file is there.
Outcome simulate(const Options& options, const std::string& scene, const std::string& trace, const Setting& setting,
                 const std::string& design, unsigned seed) {
  const std::string path = path_of(options, scene, setting, design, seed);
  if (!fs::exists(path)) {
    fs::create_directories(fs::path(path).parent_path());
    const std::string machine = fmt::format("--machine '{}'", machine_of(options));
    const std::string command = fmt::format("sim '{}' {} {} {} --stats '{}'", trace, machine, setting.arguments,
                                            setting.seed.empty() ? "" : fmt::format("{}{}", setting.seed, seed), path);
    run_program(command);
  }
  return outcome_of(path, setting.sampled);
}

/// NAME=FOLDER with the four traces.
std::string make_room(const Options& options) {
  const std::string folder = fs::absolute(options.output).string() + "/room";
  fs::create_directories(folder);
  const std::string scene = folder + "/room.ply";
  if (!fs::exists(scene)) run_program(fmt::format("synth --preset flat --count {} -o '{}'", options.room, scene));
  const std::map<std::string, std::string> designs = {{"baseline", "--accel tri20"},
                                                      {"sw", "--accel tlas-tri20"},
                                                      {"hw", "--accel tri20 --checkpoint on"},
                                                      {"grtx", "--accel tlas-tri20 --checkpoint on"}};
  for (const auto& [design, arguments] : designs) {
    const std::string trace = folder + "/" + design + ".grtx";
    if (fs::exists(trace)) continue;
    run_program(
        fmt::format("trace --machine '{}' --scene '{}' --cameras '{}/room.cameras.json' --width 64 --height 64 {} "
                    "-o '{}'",
                    machine_of(options), scene, folder, arguments, trace));
  }
  return "room=" + folder;
}

/// Errors of one setting on one scene.
struct Summary {
  std::string scene, setting;
  double speed = 0.0;                    ///< time of cycle mode over its own, four designs together
  std::array<double, 4> cycles_bias{};   ///< mean of estimate / truth - 1, by design
  std::array<double, 4> cycles_error{};  ///< mean of its absolute value
  std::array<double, 4> ratio_bias{};    ///< of speed-ups; [0] is unused
  std::array<double, 4> ratio_error{};
  double half_width = 0.0, ratio_half_width = 0.0;  ///< mean, of cycles and speed-ups
  unsigned cycles_covered = 0, cycles_all = 0, ratio_covered = 0, ratio_all = 0;
  unsigned seeds = 0;

  double mean_cycles_error() const {
    return (cycles_error[0] + cycles_error[1] + cycles_error[2] + cycles_error[3]) / 4;
  }
  double mean_ratio_error() const { return (ratio_error[1] + ratio_error[2] + ratio_error[3]) / 3; }
};

bool covers(const ConfidenceInterval& interval, double truth) {
  return interval.low <= truth && truth <= interval.high;
}

Summary summarise(const std::string& scene, const Setting& setting, const std::array<Outcome, 4>& truth,
                  const std::vector<std::array<Outcome, 4>>& runs) {
  Summary s;
  s.scene = scene;
  s.setting = setting.name;
  s.seeds = static_cast<unsigned>(runs.size());
  const double n = static_cast<double>(runs.size());
  double own = 0.0, reference = 0.0;
  for (const std::array<Outcome, 4>& run : runs) {
    for (std::size_t d = 0; d < 4; ++d) {
      own += setting.wall ? run[d].wall : run[d].cpu;
      reference += setting.wall ? truth[d].wall : truth[d].cpu;
      const double error = run[d].cycles / truth[d].cycles - 1.0;
      s.cycles_bias[d] += error / n;
      s.cycles_error[d] += std::abs(error) / n;
      const double ratio = truth[0].cycles / truth[d].cycles;
      const double ratio_error = run[0].cycles / run[d].cycles / ratio - 1.0;
      s.ratio_bias[d] += ratio_error / n;
      s.ratio_error[d] += std::abs(ratio_error) / n;
      if (!setting.sampled) continue;
      const ConfidenceInterval cycles = grtx::sim::cycles_interval(run[d].estimate);
      s.half_width += cycles.half_width / (4 * n);
      ++s.cycles_all;
      if (covers(cycles, truth[d].cycles)) ++s.cycles_covered;
      if (d == 0) continue;
      const ConfidenceInterval speedup = grtx::sim::ratio_interval(run[0].estimate, run[d].estimate);
      s.ratio_half_width += speedup.half_width / (3 * n);
      ++s.ratio_all;
      if (covers(speedup, ratio)) ++s.ratio_covered;
    }
  }
  s.speed = reference / own;
  return s;
}

std::string percent(unsigned part, unsigned whole) {
  return whole == 0 ? "" : fmt::format("{:.0f} %", 100.0 * part / whole);
}

void write_results(const Options& options, const std::vector<Summary>& all) {
  std::string csv =
      "scene,setting,seeds,speed,baseline_bias,sw_bias,hw_bias,grtx_bias,cycles_error,sw_speedup_bias,hw_speedup_bias,"
      "grtx_speedup_bias,speedup_error,cycles_half_width,speedup_half_width,cycles_coverage,speedup_coverage\n";
  fmt::print(
      "\n| scene | mode | seeds | speed | error of cycles: baseline, sw, hw, grtx | mean size | of speed-ups: sw, hw, "
      "grtx "
      "| mean size | half-widths | coverage |\n|---|---|---|---|---|---|---|---|---|---|\n");
  for (const Summary& s : all) {
    const auto share = [](unsigned part, unsigned whole) { return whole == 0 ? 0.0 : double(part) / whole; };
    csv += fmt::format(
        "{},{},{},{:.3f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},"
        "{:.3f},{:.3f}\n",
        s.scene, s.setting, s.seeds, s.speed, s.cycles_bias[0], s.cycles_bias[1], s.cycles_bias[2], s.cycles_bias[3],
        s.mean_cycles_error(), s.ratio_bias[1], s.ratio_bias[2], s.ratio_bias[3], s.mean_ratio_error(), s.half_width,
        s.ratio_half_width, share(s.cycles_covered, s.cycles_all), share(s.ratio_covered, s.ratio_all));
    fmt::print(
        "| {} | {} | {} | {:.1f} | {:+.1f}, {:+.1f}, {:+.1f}, {:+.1f} % | {:.1f} % | {:+.1f}, {:+.1f}, {:+.1f} % | "
        "{:.1f} % "
        "| {:.1f}, {:.1f} % | {}, {} |\n",
        s.scene, s.setting, s.seeds, s.speed, 100 * s.cycles_bias[0], 100 * s.cycles_bias[1], 100 * s.cycles_bias[2],
        100 * s.cycles_bias[3], 100 * s.mean_cycles_error(), 100 * s.ratio_bias[1], 100 * s.ratio_bias[2],
        100 * s.ratio_bias[3], 100 * s.mean_ratio_error(), 100 * s.half_width, 100 * s.ratio_half_width,
        percent(s.cycles_covered, s.cycles_all), percent(s.ratio_covered, s.ratio_all));
  }
  grtx::write_file(options.output + "/sim_error_vs_time.csv", csv);
}

int run(Options options) {
  if (options.room > 0) options.traces.push_back(make_room(options));
  if (options.traces.empty()) throw grtx::Error("sim_error_vs_time", "--traces", "or --room is needed");
  std::vector<Setting> settings = {{"cycle", "--mode cycle", ""}};
  for (const unsigned threads : options.threads) {
    Setting setting{fmt::format("cycle {} threads", threads), fmt::format("--mode cycle --threads {}", threads), ""};
    setting.wall = true;
    settings.push_back(setting);
  }
  for (const unsigned stride : options.strides) {
    settings.push_back({fmt::format("fast stride {}", stride), fmt::format("--mode fast --set fast.stride={}", stride),
                        stride == 1 ? "" : "--set fast.seed="});
  }
  for (const std::string& engine : options.engines) {
    for (const std::string& share : options.shares) {
      settings.push_back({fmt::format("sampled {} {}", share, engine),
                          fmt::format("--mode sampled --share {} --sample-engine {}", share, engine), "--seed ", true});
    }
  }
  std::vector<Summary> all;
  for (const std::string& scene : options.traces) {
    const std::size_t equals = scene.find('=');
    if (equals == std::string::npos) throw grtx::Error("--traces", scene, "must be NAME=FOLDER");
    const std::string name = scene.substr(0, equals), folder = scene.substr(equals + 1);
    std::map<std::string, std::vector<std::array<Outcome, 4>>> runs;
    for (unsigned seed = 1; seed <= options.seeds; ++seed) {  // interleaved: a seed of everything, then the next
      for (const Setting& setting : settings) {
        if (setting.seed.empty() && seed > 1) continue;
        const bool missing = std::any_of(kDesigns.begin(), kDesigns.end(), [&](const char* design) {
          return !fs::exists(path_of(options, name, setting, design, seed));
        });
        if (missing && options.existing) continue;
        std::array<Outcome, 4> four;
        for (std::size_t d = 0; d < 4; ++d) {
          four[d] = simulate(options, name, folder + "/" + kDesigns[d] + ".grtx", setting, kDesigns[d], seed);
        }
        runs[setting.name].push_back(four);
      }
    }
    if (!runs.contains("cycle")) throw grtx::Error(options.output, name, "has no runs in cycle mode");
    for (const Setting& setting : settings) {
      if (!runs.contains(setting.name)) continue;
      all.push_back(summarise(name, setting, runs.at("cycle").front(), runs.at(setting.name)));
    }
  }
  write_results(options, all);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  setenv("SYSTEMC_DISABLE_COPYRIGHT_MESSAGE", "1", 1);  // read by the kernel before it calls sc_main
  return sc_core::sc_elab_and_sim(argc, argv);
}

int sc_main(int argc, char* argv[]) {
  Options options;
  CLI::App app("Simulation time against error for cycle, fast and sampled mode");
  app.add_option("--traces", options.traces, "NAME=FOLDER with the traces of the four designs; repeatable");
  app.add_option("--room", options.room, "Gaussians of a generated room to trace and simulate too; 0: none");
  app.add_option("-o,--output", options.output, "Folder for results")->required();
  app.add_option("--config", options.config, "Configuration file")->capture_default_str();
  app.add_option("--machine", options.machine, "Machine, in place of a configuration file");
  app.add_option("--threads", options.threads, "Thread counts of cycle mode, by wall time; repeatable");
  app.add_option("--share", options.shares, "Shares of sampled mode; repeatable")->capture_default_str();
  app.add_option("--stride", options.strides, "Strides of fast mode; repeatable")->capture_default_str();
  app.add_option("--engine", options.engines, "Engines of sampled mode; repeatable")->capture_default_str();
  app.add_option("--seeds", options.seeds, "Seeds of sampled mode, and of fast mode with a stride above 1")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_flag("--existing", options.existing, "Simulate nothing: evaluate the runs that are there");
  CLI11_PARSE(app, argc, argv);
  try {
    return run(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "sim_error_vs_time: {}\n", error.what());
    return 2;
  }
}
