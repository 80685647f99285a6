// SPDX-License-Identifier: Apache-2.0
// Costs of shaders in instructions, the phases by which they are counted, and counters of their work.
#pragma once

#include <cstdint>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/traffic_charging.h"

namespace grtx::modules {

/// In warp instructions. The paper gives none of these; they are estimates, to be varied in sweeps.
struct ShaderCosts {
  unsigned raygen_prologue = 40;
  unsigned trace_call = 6;
  unsigned evict_move_fixed = 8;
  unsigned evict_move_per_entry = 4;  ///< per entry of the longest eviction buffer: selection of the k nearest
  unsigned any_hit_fixed = 12;        ///< load hit attributes, compare, update size and offset, report or ignore
  unsigned any_hit_per_shift = 3;     ///< compare, two moves
  unsigned any_hit_bound = 8;
  unsigned call_fixed = 0;
  unsigned call_per_lane = 0;
  unsigned intersection_fixed = 28;
  unsigned intersection_transform = 24;
  unsigned sort_per_entry = 6;  ///< compare, select, advance
  unsigned list_per_entry = 8;
  unsigned list_exchange = 5;
  unsigned list_batch = 32;  ///< list: hits per scan, sorted in registers and then blended
  TrafficCharging eviction_traffic = TrafficCharging::charged;
  bool dependent_loads = true;  ///< in the any-hit shader's loop over the k-buffer, each load waits for the previous
  unsigned blend_fixed = 10;
  unsigned blend_per_entry = 24;
  unsigned blend_with_alpha = 10;
  unsigned sh_per_coefficient = 4;
  unsigned epilogue = 10;
  unsigned node_fetch = 24;  ///< stack in shared memory: pop, address, intersect instruction, four pushes, loop

  /// Of a shader that a warp leaves traversal for, with `lanes` lanes.
  std::uint64_t call(int lanes) const {
    return call_fixed + std::uint64_t{call_per_lane} * static_cast<unsigned>(lanes);
  }

  void parameters(ParameterList& list) {
    const auto add = [&](const char* key, unsigned& cost, const char* description,
                         Origin origin = assumed("this project: operations of Listing 1 counted")) -> Parameter& {
      return list.add(key, cost, {0, 1e6}, "instructions", description, origin);
    };
    add("raygen_prologue", raygen_prologue, "pixel to ray, payload and offsets cleared");
    add("trace_call", trace_call, "operands of a traceRay call to the RT unit");
    add("evict_move_fixed", evict_move_fixed, "eviction buffer to k-buffer: set-up");
    add("evict_move_per_entry", evict_move_per_entry, "the same, per entry");
    add("any_hit_fixed", any_hit_fixed, "any-hit shader without insertion");
    add("any_hit_per_shift", any_hit_per_shift, "per k-buffer entry moved");
    add("any_hit_bound", any_hit_bound,
        "with opacity_bound: opacity of a hit that enters, or of an entry that is hidden",
        assumed("this project: 1 - alpha, its mantissa rounded up (3), logarithm, to an integer, sum, comparison"));
    const Origin of_calls = assumed("nobody publishes it; machines of cards have a fit (docs/results/silicon.md)");
    add("call_fixed", call_fixed, "a warp leaves traversal for a shader and re-enters it: message, reconvergence",
        of_calls);
    add("call_per_lane", call_per_lane, "the same, per lane that the shader is called for: its live values", of_calls);
    add("intersection_fixed", intersection_fixed,
        "intersection shader: ray in the Gaussian's space to its entry into the unit sphere, reported",
        assumed("this project: 12 products and sums for a, b and the peak, 4 for d2, a root, a quotient, 10 of call, "
                "comparison and report"));
    add("intersection_transform", intersection_transform,
        "the same, monolithic: address of the matrix, origin and direction transformed",
        assumed("this project: 3 of the address, 3 subtractions, 18 products and sums"));
    add("sort_per_entry", sort_per_entry, "single-round: per entry in a merge pass");
    add("list_per_entry", list_per_entry, "list: per entry that a scan for the next batch reads",
        assumed(
            "GRay, cuda/forward_pass.cu: 2 of the loop, address, comparisons with the last batch's end and with the "
            "farthest kept, 2 selects"));
    add("list_exchange", list_exchange, "list: per place of the sorted batch that an entry passes",
        assumed("GRay, cuda/forward_pass.cu: every entry passes all places but the last, unrolled: a comparison and 4 "
                "selects"));
    add("blend_fixed", blend_fixed, "blending: set-up and termination test");
    add("blend_per_entry", blend_per_entry, "response, alpha and transmittance");
    add("blend_with_alpha", blend_with_alpha, "the same if the hit brings its alpha: transmittance, termination test",
        assumed("this project: 24 without the response's 14"));
    add("sh_per_coefficient", sh_per_coefficient, "basis value, three colour channels");
    add("epilogue", epilogue, "pixel address and colour");
    add("node_fetch", node_fetch, "per traversal step of a warp, when shaders fetch nodes",
        assumed("this project: a traversal loop counted"));
  }
};

enum class PhaseKind : std::uint8_t {
  prologue,
  evict_move,
  trace_call,
  any_hit,
  sort,
  blend,
  epilogue,
  node_fetch,    ///< if shaders fetch nodes for the RT unit
  intersection,  ///< if leaves are boxes
};
constexpr auto enum_names(PhaseKind) {
  return names_in_order<PhaseKind>(
      {"prologue", "evict_move", "trace_call", "any_hit", "sort", "blend", "epilogue", "node_fetch", "intersection"});
}
inline constexpr std::size_t kPhaseKinds = kCountOf<PhaseKind>;

/// Work done, for conservation checks against the totals of the trace.
struct ShaderCounters {
  std::uint64_t warp_rounds = 0, ray_rounds = 0, any_hit_batches = 0, any_hit_calls = 0;
  std::uint64_t intersection_batches = 0, intersection_calls = 0;
  std::uint64_t evictions = 0, eviction_moves = 0, entries_processed = 0, entries_blended = 0;
  std::uint64_t load_instructions = 0, store_instructions = 0;
  std::uint64_t colours_made = 0;  ///< with colour = frame
  std::uint64_t heap_cycles = 0;   ///< cycles in which blending takes entries out of heaps, summed over lanes
  std::uint64_t k_buffer_mismatches = 0;
};

}  // namespace grtx::modules
