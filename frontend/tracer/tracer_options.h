// SPDX-License-Identifier: Apache-2.0
// Options of the tracer. The first value named is the default.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>

#include "grtx/frontend/gaussian/hit_options.h"
#include "grtx/frontend/gaussian/kernel.h"
#include "grtx/frontend/gaussian/simd_path.h"
#include "grtx/traces/modes.h"

namespace grtx::frontend {

// Modes that also concern the hardware model; the trace's header names them.
using traces::AnyHit;
using traces::CheckpointOrder;
using traces::ChildOrder;
using traces::ColourPer;
using traces::ErtCheck;
using traces::OpacityBound;
using traces::PopTest;
using traces::Tracing;

/// How the next round continues: after the last hit in the order (t, id), or with the paper's t_min < t.
enum class Resume : std::uint8_t { exact, strict };
constexpr auto enum_names(Resume) { return names_in_order<Resume>({"exact", "strict"}); }

/// t_max after an any-hit: the reported hit's t, or the k-th.
enum class TmaxUpdate : std::uint8_t { reported, kth };
constexpr auto enum_names(TmaxUpdate) { return names_in_order<TmaxUpdate>({"reported", "kth"}); }

/// t_max at the start of a round with a preloaded k-buffer.
enum class ReplayTmax : std::uint8_t { infinity, kth };
constexpr auto enum_names(ReplayTmax) { return names_in_order<ReplayTmax>({"infinity", "kth"}); }

/// When t_max falls inside an instance: nodes beyond it are checkpointed; or all of the instance is visited, and hits
/// beyond go to the eviction buffer.
enum class BelowInstance : std::uint8_t { checkpoint, finish };
constexpr auto enum_names(BelowInstance) { return names_in_order<BelowInstance>({"checkpoint", "finish"}); }

/// Direction in which the spherical harmonics are evaluated.
enum class ShDirection : std::uint8_t { ray, centre };
constexpr auto enum_names(ShDirection) { return names_in_order<ShDirection>({"ray", "centre"}); }

/// The test of a triangle leaf: the canonical hit function, or its stored vertices
/// (frontend/gaussian/world_triangle.h).
enum class TriangleTest : std::uint8_t { canonical, world };
constexpr auto enum_names(TriangleTest) { return names_in_order<TriangleTest>({"canonical", "world"}); }

struct TracerOptions {
  unsigned k = 8;           ///< k-buffer entries, 1..2048
  bool checkpoint = false;  ///< checkpointing and replay
  /// Entries of one checkpoint buffer of a ray; offsets have 2 B in the paper, so at most 65,535. The default is what
  /// 97.68 MiB over 8 SMs, 32 warps and 32 lanes leave for two buffers and an eviction buffer (not stated in the
  /// paper).
  unsigned checkpoint_capacity = 1024;
  unsigned checkpoint_bins = 0;  ///< near bins by distance (and a far one) of checkpoint_capacity; 0: two buffers
  BelowInstance below_instance = BelowInstance::checkpoint;  ///< with checkpoint
  float ert = 0.001f;                                        ///< stop when transmittance falls below
  ErtCheck ert_check = ErtCheck::hit;                        ///< round: the image depends on k; not for tracing = list
  SortKey sort_key = SortKey::entry;
  Resume resume = Resume::exact;
  InsideRule inside = InsideRule::skip;
  TmaxUpdate tmax_update = TmaxUpdate::reported;
  /// on: needs tracing = multi, any_hit = immediate, ert_check = hit and an ert of kLeastBoundedErt.
  OpacityBound opacity_bound = OpacityBound::off;
  CheckpointOrder checkpoint_order = CheckpointOrder::fifo;
  ReplayTmax replay_tmax = ReplayTmax::infinity;
  ChildOrder child_order = ChildOrder::near_first;
  PopTest pop_test = PopTest::on;
  AnyHit any_hit = AnyHit::immediate;  ///< delayed needs tracing = multi without checkpoint
  /// Nodes of a ray under way at once, 1..traces::kMostAhead: what a node finds changes t_max only when it is done.
  /// More than 1 needs tracing = multi, any_hit = immediate, one level and no checkpoint.
  unsigned ahead = 1;
  ShDirection sh_direction = ShDirection::ray;
  /// When colours are made. frame needs sh_direction = centre, a scene of one object, and no secondary rays.
  ColourPer colour = ColourPer::hit;
  Kernel kernel;                     ///< kernel of the traced Gaussians
  Tracing tracing = Tracing::multi;  ///< checkpoint needs multi; closest needs k = 1
  unsigned list_capacity = 1024;     ///< tracing = list: hits in a ray's list; k must be the same
  TriangleTest triangle_test = TriangleTest::canonical;
  ResponsePrecision response_precision = ResponsePrecision::fp32;
  bool walk_blas = true;             ///< false: the hit function decides at the instance leaf, as no hardware does
  SimdPath simd = best_simd_path();  ///< changes no bit of the result
};

inline constexpr unsigned kMaxK = 2048;
/// Least threshold whose quotients and products are normal floats (traces/rules/opacity_sum.h).
inline constexpr float kLeastBoundedErt = 1e-30f;

}  // namespace grtx::frontend
