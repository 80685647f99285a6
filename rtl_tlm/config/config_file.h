// SPDX-License-Identifier: Apache-2.0
// Reading configuration files and `--set` into a list of keys.
#pragma once

#include <string>
#include <vector>

#include "grtx/modules/kernel/declare.h"

namespace grtx::sim {

/// Reads a TOML file into `keys`. Keys that the file does not name keep their value: a file states differences only;
/// every command and load_config() start from the machine `paper`. `include = "other.toml"` (path relative to the file;
/// a list is read in order) is read first. Throws Error{file, "line N", rule}: syntax, unknown key (with the nearest
/// known one), wrong type, value out of range, missing or circular include.
void load_config_file(const std::string& path, const std::vector<modules::Parameter>& keys);

/// Applies "key=value". Throws Error{"--set", key, rule}.
void apply_setting(const std::string& setting, const std::vector<modules::Parameter>& keys);

}  // namespace grtx::sim
