// Options of the tracer. The first value named is the default.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "grtx/frontend/gaussian/canonical_hit.h"
#include "grtx/frontend/gaussian/response_precision.h"
#include "grtx/frontend/gaussian/simd_path.h"
#include "grtx/frontend/tracer/skips.h"

namespace grtx::frontend {

enum class Resume : std::uint8_t { exact, strict };
enum class TmaxUpdate : std::uint8_t { reported, kth };
enum class CheckpointOrder : std::uint8_t { fifo, lifo, nearest };
enum class ReplayTmax : std::uint8_t { infinity, kth };
enum class ChildOrder : std::uint8_t { near_first, slot };
enum class ShDirection : std::uint8_t { ray, centre };

/// How a round collects hits. multi: the k nearest, in a sorted k-buffer. single: all, unsorted, in a buffer of k
/// entries, sorted when the round ends. closest: the nearest one, without an any-hit shader.
enum class Tracing : std::uint8_t { multi, single, closest };
/// What a triangle leaf is tested with: the canonical hit function, or its stored vertices
/// (frontend/gaussian/world_triangle.h).
enum class TriangleTest : std::uint8_t { canonical, world };

struct TracerOptions {
  unsigned k = 8;           ///< k-buffer entries, 1..2048
  bool checkpoint = false;  ///< checkpointing and replay
  /// Entries of one checkpoint buffer of a ray; offsets have 2 B in the paper, so at most 65,535. The default is what
  /// 97.68 MiB over 8 SMs, 32 warps and 32 lanes leave for two buffers and an eviction buffer (facts:
  /// under-determined).
  unsigned checkpoint_capacity = 1024;
  float ert = 0.001f;  ///< stop when transmittance falls below
  SortKey sort_key = SortKey::entry;
  Resume resume = Resume::exact;
  InsideRule inside = InsideRule::skip;
  TmaxUpdate tmax_update = TmaxUpdate::reported;
  CheckpointOrder checkpoint_order = CheckpointOrder::fifo;
  ReplayTmax replay_tmax = ReplayTmax::infinity;
  ChildOrder child_order = ChildOrder::near_first;
  ShDirection sh_direction = ShDirection::ray;
  bool adaptive_radius = true;
  Tracing tracing = Tracing::multi;  ///< checkpoint needs multi; closest needs k = 1
  TriangleTest triangle_test = TriangleTest::canonical;
  ResponsePrecision response_precision = ResponsePrecision::fp32;
  Skips skips = kFaithfulSkips;      ///< change no bit of the image
  SimdPath simd = best_simd_path();  ///< changes no bit of the result
};

inline constexpr unsigned kMaxK = 2048;

}  // namespace grtx::frontend
