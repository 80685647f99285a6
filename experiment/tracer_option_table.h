// SPDX-License-Identifier: Apache-2.0
// Table of the tracer's options: name, value, description and rule of each.
#pragma once

#include <string_view>

#include "grtx/experiment/secondary_options.h"
#include "grtx/experiment/tracer_settings.h"
#include "grtx/traces/checkpoint_bins.h"
#include "grtx/traces/modes.h"

namespace grtx::experiment {

inline constexpr const char* kKernelDegree =
    "n of a Gaussian's response exp(-4.5 (d/3)^n), d in standard deviations: 2 is 3DGS, 4 what 3DGRT trains by default";

/// Calls visit(name, value, description[, rule]) for each option that a trace header records in its inputs, in the
/// order of --help. settings may be const.
template <typename Settings, typename Visit>
void visit_traced_options(Settings& settings, Visit&& visit) {
  auto& o = settings.options;
  visit("k", o.k, "k-buffer entries per ray", InRange{1U, frontend::kMaxK});
  visit("checkpoint-capacity", o.checkpoint_capacity, "Entries of one checkpoint buffer of a ray", InRange{1U, 65535U});
  visit("checkpoint-bins", o.checkpoint_bins,
        "Near lists of a ray by distance, and a far one, of --checkpoint-capacity entries each; 0: two buffers",
        InRange{0U, traces::kMaxCheckpointBins});
  visit("below-instance", o.below_instance,
        "Nodes of an instance beyond t_max: checkpointed, or visited, and a hit goes to the eviction buffer");
  visit("ert", o.ert, "Transmittance below which a ray ends", InRange{0.0, 1.0});
  visit(
      "ert-check", o.ert_check,
      "When transmittance is tested: after each hit, or once per round, when all its hits are blended; the image then "
      "depends on --k");
  visit("sort-key", o.sort_key, "Distance that orders a ray's hits");
  visit("resume", o.resume, "How a round continues: (t, id) order, or the paper's t_min < t");
  visit("kernel-radius", settings.kernel_radius,
        "Radius at which a Gaussian ends: by its opacity, or three standard deviations");
  visit("kernel-degree", settings.kernel_degree, kKernelDegree, AnyOf{{2U, 4U}});
  visit("child-order", o.child_order, "Order in which hit children are visited; a machine may choose another");
  visit(
      "pop-test", o.pop_test,
      "Whether a popped node is compared with t_max before its fetch (stack entries then hold t); a machine may choose "
      "another");
  visit("any-hit", o.any_hit,
        "When any-hit shaders run: while the ray waits, or when its warp's traversal of the round has ended; a machine "
        "may choose another");
  visit("ahead", o.ahead,
        "Nodes of a ray under way at once, so that t_max is known later, as in a warp that runs ahead; a machine may "
        "choose another",
        InRange{1U, traces::kMostAhead});
  visit("tmax-update", o.tmax_update, "t_max after an any-hit: the reported hit's t, or the k-th");
  visit("opacity-bound", o.opacity_bound,
        "Whether t_max also moves to the hit at which the hits found so far let less light through than --ert");
  visit("checkpoint-order", o.checkpoint_order, "Order in which replay reads the source buffer");
  visit("replay-tmax", o.replay_tmax, "t_max at the start of a round with a preloaded k-buffer");
  visit("inside", o.inside, "Gaussians whose proxy holds the ray origin: skipped, or hit at distance 0");
  visit("sh-dir", o.sh_direction, "Direction in which the spherical harmonics are evaluated");
  visit("colour", o.colour,
        "When the colour of a Gaussian is made: for each hit, or once in a frame as fp16, which needs --sh-dir centre");
  visit("instance-bounds", settings.instance_bounds,
        "Boxes of instances in the world: of the proxy, or of its box's corners");
  visit("layout", settings.layout, "How nodes lie in memory (docs/model/node-image.md)");
  visit("bvh-width", settings.bvh_width,
        "Children of an internal node; with --layout compact or compressed 8 by default", InRange{2U, 8U});
  visit("mapping", settings.mapping, "How pixels form warps; tiles of 16, 8, 4: 4x4, 4x2, 2x2");
  visit("warp-size", settings.warp_size, "Rays of a warp", OneOf{{"4", "8", "16", "32"}});
  visit("tracing", settings.tracing,
        "multi: rounds of k hits; single: one round, then a sort (--k holds all hits); closest: a round a hit; list: "
        "one traversal, all hits to a list of the ray in memory, blended in batches of the nearest",
        OneOf{names_of<frontend::Tracing>(), "tiles",
              "--tracing single makes the same image, fastest with --k 64 or more"});
  visit("list-capacity", o.list_capacity,
        "Hits that the list of a ray holds, with --tracing list; more take a further "
        "pass",
        InRange{1U, frontend::kMaxK});
  visit("triangle-test", o.triangle_test, "Hit test of triangles: canonical, or their stored vertices");
  visit("box-bits", settings.box_bits, "Bits used of a stored box coordinate (a node keeps its size)", InRange{2U, 8U});
  visit("response-precision", o.response_precision, "Format to which every step of a Gaussian's response is rounded");
}

/// The same for all options.
template <typename Settings, typename Visit>
void visit_options(Settings& settings, Visit&& visit) {
  visit_traced_options(settings, [&](const char* name, auto& value, const char* description, const auto&... rule) {
    visit(name, value, description, rule...);
    if (std::string_view(name) == "warp-size") visit_secondary(settings.secondary, visit);
  });
  visit("threads", settings.threads, "Threads; 0 takes all");
}

}  // namespace grtx::experiment
