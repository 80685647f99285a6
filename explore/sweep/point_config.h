// SPDX-License-Identifier: Apache-2.0
// The configurations of a plan's points. There may be a hundred thousand that differ in only a few keys, so they share
// the entries of the plan's base configuration.
#pragma once

#include <cstddef>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "grtx/base/json.h"
#include "grtx/rtl_tlm/gpu/config_trial.h"

namespace grtx::explore {

class PointConfig {
 public:
  /// The configuration as config_json() writes it, as text without spaces.
  std::string text() const;
  nlohmann::ordered_json json() const { return parse_json(text(), "configuration"); }
  /// FilesRead::hash() of the memory model's configuration files; "" if it has none.
  const std::string& memory_files() const { return memory_files_; }

 private:
  friend class PointConfigs;
  /// `"key":value` of each key, in order.
  struct Base {
    std::vector<std::string> entries;
    std::size_t length = 0;  ///< total length of all entries
  };
  std::shared_ptr<const Base> base_;
  std::vector<std::pair<std::size_t, std::string>> changed_;  ///< entries that differ, by index
  std::string memory_files_;
};

/// Creates configurations from a plan's base.
class PointConfigs {
 public:
  using Settings = std::vector<std::pair<std::string, std::string>>;

  /// rivals: keys of the memory clock that the base sets.
  explicit PointConfigs(const sim::GpuConfig& base, const sim::RivalKeys& rivals = {});
  /// The base with these keys set; the last setting of a key counts. If no such machine can exist and `broken` is
  /// empty, sets it to the reason. Throws Error for an unknown key or invalid value.
  PointConfig with(const Settings& settings, std::string& broken);

 private:
  sim::ConfigTrial trial_;
  sim::RivalKeys rivals_;
  std::shared_ptr<const PointConfig::Base> base_;
};

}  // namespace grtx::explore
