// SPDX-License-Identifier: Apache-2.0
// Timing of the heap of a ray's k nearest hits, which the any-hit unit keeps in the registers of the ray's warp in
// place of a shader. GauTracer (ISCA 2026): a max-heap of t, alpha and id, 2 to 12 cycles per operation.
#pragma once

#include <bit>

#include "grtx/base/strong.h"
#include "grtx/modules/kernel/declare.h"

namespace grtx::modules {

struct HitHeap {
  static constexpr unsigned kEntryWords = 3;  ///< t, alpha, id: registers of a thread for each entry

  bool enabled = false;  ///< else hits go to the any-hit shader, and k-buffers are in memory
  bool alpha = false;    ///< entries hold alpha, which the Gaussian unit computes; set by the assembly
  unsigned latency = 2;
  unsigned level_latency = 2;

  void parameters(ParameterList& list) {
    const char* const gautracer = "GauTracer, ISCA 2026: 2 to 12 cycles per operation";
    list.add("enabled", enabled, "hits enter a heap in the registers of their warp; no any-hit shader runs",
             from_public("GauTracer, ISCA 2026"));
    list.add("latency", latency, {1, kMaxLatency}, "cycles", "an operation that compares with the heap's root only",
             from_public(gautracer));
    list.add("level_latency", level_latency, {0, kMaxLatency}, "cycles", "per level of the heap that an entry passes",
             from_public(gautracer));
  }

  /// Levels below the root in a heap of `entries` (>= 1).
  static unsigned levels(unsigned entries) { return static_cast<unsigned>(std::bit_width(entries)) - 1; }
  /// A hit enters a heap that then has `entries`: it may rise through all levels.
  Cycle insertion(unsigned entries) const { return latency + Cycle{level_latency} * levels(entries); }
  /// A hit takes the root's place in a heap of `entries` and sinks.
  Cycle displacement(unsigned entries) const { return latency + Cycle{level_latency} * (levels(entries) + 1); }
  /// Takes all of `entries` out in order, for blending.
  Cycle drain(unsigned entries) const {
    Cycle cycles = 0;
    for (; entries > 0; --entries) cycles += displacement(entries);
    return cycles;
  }
};

}  // namespace grtx::modules
