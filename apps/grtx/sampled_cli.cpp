#include "grtx/apps/grtx/sampled_cli.h"

#include <fmt/format.h>

#include <charconv>

#include "grtx/apps/grtx/options.h"
#include "grtx/base/error.h"
#include "grtx/explore/cost/energy_statistics.h"
#include "grtx/rtl_tlm/gpu/mode_keys.h"

namespace grtx::sim {
namespace {

/// "2%" or "0.02".
double parse_error(const std::string& text) {
  const bool percent = text.ends_with('%');
  const char* const end = text.data() + text.size() - (percent ? 1 : 0);
  double value = 0.0;
  const auto [stop, failed] = std::from_chars(text.data(), end, value);
  if (failed != std::errc() || stop != end || !(value > 0.0)) {
    throw Error("--target-error", text, "must be a share above 0 and below 1, like 2% or 0.02");
  }
  return percent ? value / 100.0 : value;
}

}  // namespace

void add_sampled_options(CLI::App* command, SampledCli& cli) {
  command->add_option("--share", cli.share,
                      "Sampled mode: share of the warps to simulate, in windows of the trace, above 0, at most 1");
  command->add_option("--target-error", cli.target_error,
                      "Sampled mode: go on until the 95 % interval on cycles is this narrow, e.g. 2% (default: none)");
  command->add_option("--seed", cli.seed, "Sampled mode: where the windows are; the same for every design");
  add_choice(command, "--sample-engine", cli.engine, "Sampled mode: what simulates the windows", runs_windows);
}

SampledOptions sampled_options(const SampledCli& cli, SimulationMode mode) {
  const SampledCli defaults;
  if (mode != SimulationMode::sampled) {
    const auto refuse = [](const char* option) { throw Error(option, "", "needs --mode sampled"); };
    if (cli.share != defaults.share) refuse("--share");
    if (!cli.target_error.empty()) refuse("--target-error");
    if (cli.seed != defaults.seed) refuse("--seed");
    if (cli.engine != defaults.engine) refuse("--sample-engine");
  }
  SampledOptions options;
  options.share = cli.share;
  if (!cli.target_error.empty()) options.target_error = parse_error(cli.target_error);
  options.seed = cli.seed;
  options.engine = cli.engine;
  options.price = describe_energy;
  check_sampled(options);
  return options;
}

void warn_of_ignored_keys(const GpuConfig& config, SimulationMode mode, const SampledOptions& sampled) {
  std::vector<SimulationMode> modes = {mode};
  // A trace that windows do not suit is run in cycle mode.
  if (mode == SimulationMode::sampled) modes = {sampled.engine, SimulationMode::cycle};
  warn_of_ignored_keys(config, modes, "--mode " + std::string(name_of(mode)));
}

void print_sampled(const SampledResult& r) {
  const auto& stats = r.result.document.at("stats");
  const auto number = [&stats](const char* name) { return stats.at(name).at("value").get<double>(); };
  if (r.estimate.whole) return;  // which a line on stderr has said
  say("sampled: {:.0f} groups ({:.1f} %) in {:.0f} windows; {:.0f} % interval {:.0f} to {:.0f} cycles, ±{:.1f} %",
      number("gpu.sampled.groups"), 100.0 * number("gpu.sampled.share"), number("gpu.sampled.windows"),
      100.0 * number("gpu.sampled.confidence"), r.cycles.low, r.cycles.high, 100.0 * r.cycles.half_width);
}

}  // namespace grtx::sim
