// SPDX-License-Identifier: Apache-2.0
// Reading configuration files and `--set` into a list of keys.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "grtx/modules/kernel/declare.h"

namespace grtx::sim {

/// Where a file sets a key. comment: what stands behind it on its line, by habit its source.
struct KeyPlace {
  std::string file;
  unsigned line = 0;
  std::string comment;
};
using KeyPlaces = std::map<std::string, KeyPlace>;  ///< by key

/// Reads a TOML file into `keys`. Keys that the file does not name keep their value: a file states differences only;
/// every command and load_config() start from the machine `paper`. `include = "other.toml"` (path relative to the file;
/// a list is read in order) is read first. Throws Error{file, "line N", rule}: syntax, unknown key (with the nearest
/// known one), wrong type, value out of range, missing or circular include, two keys that set the memory clock. places:
/// takes the place of every key that is set.
void load_config_file(const std::string& path, const std::vector<modules::Parameter>& keys,
                      KeyPlaces* places = nullptr);

/// "" or why these keys cannot be named together: dram.mhz and dram.bandwidth_gb_s both set the memory clock.
std::string contradiction(bool names_mhz, bool names_bandwidth);

/// Applies "key=value". Throws Error{"--set", key, rule}.
void apply_setting(const std::string& setting, const std::vector<modules::Parameter>& keys);

}  // namespace grtx::sim
