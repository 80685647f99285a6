// Reading configuration files and `--set` into a list of keys.
#pragma once

#include <string>
#include <vector>

#include "grtx/modules/kernel/declare.h"

namespace grtx::sim {

/// Reads a TOML file into `keys`; what it does not say stays as it is: a file states differences from what was there,
/// for every command and load_config() the machine `paper`. `include = "other.toml"` (path relative to the file; a list
/// is read in order) is read first, so that a file says only what differs. Throws Error{file, "line N", rule}: syntax,
/// unknown key (with the nearest known one), wrong type, value out of range, missing or circular include.
void load_config_file(const std::string& path, const std::vector<modules::Parameter>& keys);

/// Applies "key=value". Throws Error{"--set", key, rule}.
void apply_setting(const std::string& setting, const std::vector<modules::Parameter>& keys);

}  // namespace grtx::sim
