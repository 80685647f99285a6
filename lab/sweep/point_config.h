// The configurations of a plan's points. A plan may have a hundred thousand of them that differ in a few of all keys:
// they share what the plan's base says.
#pragma once

#include <cstddef>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "grtx/base/json.h"
#include "grtx/rtl_tlm/gpu/config_trial.h"

namespace grtx::sim {

class PointConfig {
 public:
  /// As config_json() has it, written without spaces.
  std::string text() const;
  nlohmann::ordered_json json() const { return parse_json(text(), "configuration"); }
  /// FilesRead::hash() of what configures its memory; "" for a memory without files.
  const std::string& memory_files() const { return memory_files_; }

 private:
  friend class PointConfigs;
  /// `"key":value` of each key, in order.
  struct Base {
    std::vector<std::string> entries;
    std::size_t length = 0;  ///< of all together
  };
  std::shared_ptr<const Base> base_;
  std::vector<std::pair<std::size_t, std::string>> changed_;  ///< entries that differ, by index
  std::string memory_files_;
};

/// Makes them, each from the plan's base.
class PointConfigs {
 public:
  using Settings = std::vector<std::pair<std::string, std::string>>;

  explicit PointConfigs(const GpuConfig& base);
  /// The base with these keys set, the later one of a key set twice. `broken`, if empty, says why there is no such
  /// machine. Throws Error for a key that is unknown or does not take its value.
  PointConfig with(const Settings& settings, std::string& broken);

 private:
  ConfigTrial trial_;
  std::shared_ptr<const PointConfig::Base> base_;
};

}  // namespace grtx::sim
