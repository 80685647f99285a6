// SPDX-License-Identifier: Apache-2.0
// A hit as the tracer keeps it.
#pragma once

#include <cstdint>

#include "grtx/traces/rules/k_buffer.h"

namespace grtx::frontend {

struct KEntry {
  float t = 0.0f;
  std::uint32_t id = 0;
  float d2 = 0.0f;  ///< squared distance at peak response, kernel radius = 1; recomputed by the shader in hardware
  std::uint32_t opacity = 0;  ///< traces::opacity_steps(); 0 unless TracerOptions::opacity_bound is on
  friend bool operator<(const KEntry& a, const KEntry& b) { return a.t < b.t || (a.t == b.t && a.id < b.id); }
};
using KBuffer = traces::KBuffer<KEntry>;

}  // namespace grtx::frontend
