#include "grtx/rtl_tlm/estimate/fast/measured_region.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

namespace grtx::sim {
namespace {

constexpr double kFactor = 4.0;

/// What the machines say, where that is not within the factor of the default, or is all that is known.
struct Span {
  std::string_view key;
  double low, high;
};
constexpr Span kMachines[] = {
    {"fast.stride", 0, 8},
    {"gpu.sms", 1, 170},
    {"l1.bytes", 16384, 524288},
    {"l1.ways", 4, 1024},
    {"l1.line_bytes", 128, 128},
    {"l2.bytes", 262144, 101e6},
    {"l2.slices", 1, 32},
    {"l2.line_bytes", 128, 128},
    {"l2.mshr_merges", 4, 1e9},  // no merge waits in fast mode
    {"dram.fixed_latency", 90, 1024},
    {"dram.bank_groups", 1, 4},
    {"dram.timing.ccd", 2, 16},
    {"dram.timing.turn", 1, 8},
    {"dram.timing.ccd_l", 0, 16},
    {"dram.timing.rrd_l", 0, 32},
    {"dram.timing.cdlr_l", 0, 44},
    {"dram.timing.rcd_wr", 0, 64},
    {"dram.timing.faw", 0, 116},
    {"dram.timing.refi", 1250, 20000},
    {"dram.timing.rfc", 0, 844},
    {"simt.registers", 1, 1e9},
    {"dram.group_bytes", 32, 1e6},
    {"rt.transform.interval", 1, 24},
};

bool inside(std::string_view key, double value, double usual) {
  if (value == usual) return true;
  const auto* span =
      std::find_if(std::begin(kMachines), std::end(kMachines), [&](const Span& s) { return s.key == key; });
  if (span != std::end(kMachines)) return value >= span->low && value <= span->high;
  return value >= usual / kFactor && value <= usual * kFactor;
}

}  // namespace

std::string outside_of_measured(const GpuConfig& config, std::uint64_t groups, std::uint64_t visits) {
  GpuConfig own = config, defaults;
  const std::vector<modules::Parameter> keys = config_keys(own), usual = config_keys(defaults);
  std::vector<std::string> outside;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i].name == "fast.seed") continue;
    std::visit(
        [&](const auto& value) {
          using Value = std::decay_t<decltype(value)>;
          if constexpr (std::is_pointer_v<Value> && !std::is_same_v<Value, bool*>) {
            const auto number = static_cast<double>(*value);
            if (!inside(keys[i].name, number, static_cast<double>(*std::get<Value>(usual[i].value)))) {
              outside.push_back(fmt::format("{} = {}", keys[i].name, value_text(keys[i])));
            }
          }
        },
        keys[i].value);
  }
  if (groups < kFewestMeasuredGroups) outside.push_back(fmt::format("a trace of {} groups", groups));
  if (visits < kFewestMeasuredVisits) outside.push_back(fmt::format("{} node visits", visits));
  return fmt::format("{}", fmt::join(outside, ", "));
}

ResultNotes outside_notes(std::string_view mode, const std::string& outside) {
  if (outside.empty()) return {};
  return {{"outside-measured", fmt::format("outside of what was measured for --mode {}: {}", mode, outside)}};
}

}  // namespace grtx::sim
