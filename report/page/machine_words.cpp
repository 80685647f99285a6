// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/page/machine_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "grtx/base/error.h"
#include "grtx/explore/sweep/axis.h"
#include "grtx/explore/sweep/points.h"
#include "grtx/rtl_tlm/gpu/unset_key.h"

namespace grtx::report {

std::string loses_most_text(const std::vector<std::pair<std::string, double>>& times, const std::string& machine,
                            const std::string& over) {
  std::vector<std::pair<std::string, double>> known;
  std::ranges::copy_if(times, std::back_inserter(known), [](const auto& own) { return std::isfinite(own.second); });
  if (known.empty()) return "";
  const auto [least, most] = std::ranges::minmax_element(known, {}, &std::pair<std::string, double>::second);
  constexpr double kAlike = 0.005;  // what is printed as 1.00 is neither loss nor gain
  const bool loses = least->second < 1.0 - kAlike, gains = most->second >= 1.0 + kAlike;
  if (!loses && !gains)
    return fmt::format("on {} {} as fast as on {}", machine,
                       known.size() == 1 ? known.front().first + " is" : "all designs are", over);
  std::string text = fmt::format("on {} {} {}: {:.2f} times as fast as on {}", machine, least->first,
                                 loses ? "loses most" : "gains least", least->second, over);
  if (least == most) return text;
  return text + fmt::format("; {} {}: {:.2f} times", most->first,
                            !loses  ? "most"
                            : gains ? "gains"
                                    : "least",
                            most->second);
}

std::string key_text(const nlohmann::ordered_json& config, const std::string& key) {
  const std::string own = config.contains(key) ? explore::text_of(config.at(key)) : "";
  if (own != "0" && own != "0.0") return own;
  try {
    sim::GpuConfig machine = explore::config_from(config);
    for (const modules::Parameter& parameter : sim::config_keys(machine)) {
      if (parameter.name != key || sim::is_set(parameter)) continue;
      const bool derived = key == "dram.bandwidth_gb_s" && machine.dram_model == sim::kBuiltInMemory;
      return derived ? fmt::format("{:.1f}, by dram.mhz", machine.peak_dram_gb_s()) : "not set";
    }
  } catch (const Error&) {  // of another version, whose keys say nothing here
  }
  return own;
}

}  // namespace grtx::report
