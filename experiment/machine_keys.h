// SPDX-License-Identifier: Apache-2.0
// The resolved keys of a machine, each with value, origin, source and confidence, and figures that follow from
// them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/experiment/machine.h"

namespace grtx::experiment {

struct MachineKey {
  std::string name;  ///< of a tracer option "tracer.NAME"
  nlohmann::ordered_json value;
  bool set = true;  ///< false: the value is 0, which here means that nobody sets it
  std::string unit;
  std::string from;        ///< "default", "ada.toml:11", "--set" or "--design NAME"
  std::string source;      ///< of a default, or the comment behind the key in its file
  std::string confidence;  ///< of a default (declare::Confidence); "": a file's own value, of which its comment says it
};

/// A figure that follows from several keys.
struct MachineFigure {
  std::string name;
  double value = 0.0;
  std::string unit;
  std::string follows;  ///< the keys that make it
};

struct MachineKeys {
  std::vector<MachineKey> keys;
  std::vector<MachineFigure> figures;
};

/// Throws the Errors of choose_machine().
MachineKeys machine_keys(const MachineChoice& choice);

}  // namespace grtx::experiment
