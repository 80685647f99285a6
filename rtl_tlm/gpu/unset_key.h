// SPDX-License-Identifier: Apache-2.0
// Keys whose value is 0 because nobody sets them: another key, or no limit, holds then.
#pragma once

#include <string>

#include "grtx/rtl_tlm/gpu/config_trial.h"

namespace grtx::sim {

/// Whether a key has a value of its own: false for a 0 that means that nobody sets it, as its description says.
inline bool is_set(const modules::Parameter& key) {
  return key.description.find("; 0: ") == std::string::npos || value_json(key) != 0;
}

}  // namespace grtx::sim
