// SPDX-License-Identifier: Apache-2.0
#include "grtx/apps/grtx/estimate_cli.h"

#include <fmt/format.h>

#include <charconv>

#include "grtx/apps/grtx/options.h"
#include "grtx/base/error.h"
#include "grtx/explore/cost/energy_statistics.h"
#include "grtx/rtl_tlm/estimate/windows/window_refusal.h"

namespace grtx::apps {
namespace {

/// Parses "2%" or "0.02" as a share.
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

CLI::Option* add_mode_option(CLI::App* command, sim::SimulationMode& mode, const std::string& description) {
  const CLI::Validator known = one_of(names_of<sim::SimulationMode>());
  const auto check = [known](std::string& name) {
    const std::string gone = sim::gone_mode(name);
    return gone.empty() ? known(name) : gone;
  };
  return command
      ->add_option_function<std::string>(
          "--mode", [&mode](const std::string& name) { mode = *from_name<sim::SimulationMode>(name); }, description)
      ->default_str(std::string(name_of(mode)))
      ->check(CLI::Validator(check, known.get_description()));
}

void add_estimate_options(CLI::App* command, EstimateCli& cli) {
  command->add_option("--target-error", cli.target_error,
                      "Windows mode: go on until the 95 % interval on cycles is this narrow, e.g. 2% "
                      "(default: none)");
  command->add_option("--share", cli.share, "Windows mode: share of the warps to simulate, at least 0.25, at most 1");
  command->add_option("--seed", cli.seed, "Windows mode: where the windows are; the same for every design");
}

sim::WindowOptions estimate_options(const EstimateCli& cli, sim::SimulationMode mode) {
  const EstimateCli defaults;
  const auto needs = [](const char* option, const char* modes) {
    throw Error(option, "", fmt::format("needs --mode {}", modes));
  };
  if (mode != sim::SimulationMode::windows) {
    if (!cli.target_error.empty()) needs("--target-error", "windows");
    if (cli.share != defaults.share) needs("--share", "windows");
    if (cli.seed != defaults.seed) needs("--seed", "windows");
  }
  sim::WindowOptions options;
  options.share = cli.share;
  if (!cli.target_error.empty()) options.target_error = parse_error(cli.target_error);
  options.seed = cli.seed;
  options.price = explore::describe_energy;
  sim::check_windows(options);
  return options;
}

void print_interval(const sim::EstimatedResult& r) {
  if (r.estimate.whole) return;  // exact; a note says so
  const auto& stats = r.result.document.at("stats");
  const auto number = [&stats](const char* name) { return stats.at(name).at("value").get<double>(); };
  say("windows: {:.0f} groups ({:.1f} %) in {:.0f} windows; {:.0f} % interval {:.0f} to {:.0f} cycles, ±{:.1f} %",
      number("gpu.windows.groups"), 100.0 * number("gpu.windows.share"), number("gpu.windows.count"),
      100.0 * number("gpu.windows.confidence"), r.cycles.low, r.cycles.high, 100.0 * r.cycles.half_width);
}

}  // namespace grtx::apps
