// SPDX-License-Identifier: Apache-2.0
// A comparison of machines in words, the same on the page and as text: which design loses most, and what the value of a
// key comes to.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace grtx::report {

/// "on own gautracer loses most: 0.68 times as fast as on paper-charged; walk least: 0.99 times". times: by design, how
/// many times as fast it is on `machine` as on `over`; not finite where unknown. "" without one.
std::string loses_most_text(const std::vector<std::pair<std::string, double>>& times, const std::string& machine,
                            const std::string& over);

/// The value of a key of a resolved configuration: where it is 0 since nobody sets it, the figure that holds then, as
/// "112.0, by dram.mhz", or "not set".
std::string key_text(const nlohmann::ordered_json& config, const std::string& key);

}  // namespace grtx::report
