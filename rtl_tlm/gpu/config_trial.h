// SPDX-License-Identifier: Apache-2.0
// A configuration on which many sets of values are tried. Its keys and rules are built only once, which takes as long
// as trying a thousand values.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <unordered_map>
#include <vector>

#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {

class ConfigTrial {
 public:
  explicit ConfigTrial(GpuConfig base);
  ConfigTrial(const ConfigTrial&) = delete;  // keys point into it
  ConfigTrial& operator=(const ConfigTrial&) = delete;

  /// All keys, in the order of config_keys().
  const std::vector<modules::Parameter>& keys() const { return list_.items(); }
  /// Sets a key as `--set` does, until reset(); returns its place in keys(). Throws Error.
  std::size_t set(const std::string& name, const std::string& value);
  /// check_config() of the present values.
  void check(const std::string& origin);
  const GpuConfig& config() const { return config_; }
  /// Restores the values of `base`.
  void reset();

 private:
  // Never assigned as a whole: the keys of user-supplied units point into what an assignment replaces.
  GpuConfig config_;
  modules::ParameterList list_;
  std::unordered_map<std::string, std::size_t> places_;  ///< of keys, by name
  std::vector<std::string> base_;                        ///< values, by place
  std::vector<std::size_t> set_;                         ///< places of keys that were set
};

/// The present value of a key as config_json() has it.
nlohmann::ordered_json value_json(const modules::Parameter& key);

}  // namespace grtx::sim
