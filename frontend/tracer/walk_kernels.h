// What a ray's walk by lists works on (frontend/tracer/ray_walk.h), and its two inner loops, which run on the vector
// instructions of frontend/gaussian/simd_path.h. All paths make the same lists, bit for bit.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "grtx/frontend/accel/node_image.h"
#include "grtx/frontend/gaussian/simd_path.h"
#include "grtx/frontend/gaussian/slab_intersection.h"

namespace grtx::frontend {

/// Nodes that a ray knows, in the order of its walk, as arrays.
struct WalkList {
  /// What a node's `state` may be, besides the t of a leaf's hit (>= 0). Numbers below zero ask for attention.
  static constexpr float kOpen = -1.0f;                                    ///< not visited yet
  static constexpr float kGuarded = -2.0f;                                 ///< see WalkGuard
  static constexpr float kDone = std::numeric_limits<float>::quiet_NaN();  ///< opened, or a leaf without a hit

  /// In `what`. Addresses are thus below 2^31 units: node images of up to 128 GB.
  static constexpr std::uint32_t kLeaf = 1u << 31;
  /// Written behind the last element: whole vectors.
  static constexpr std::uint32_t kSlack = 32;

  std::vector<float> enter;  ///< conservative entry t
  std::vector<float> exit;   ///< least conservative exit t of the node and those above it
  std::vector<float> state;
  /// kLeaf, and with kOpen the node's address in units; opened: its number; hit: the hit's; guarded: its guard's.
  std::vector<std::uint32_t> what;
  std::uint32_t size = 0;

  void reserve(std::uint32_t elements) {
    if (enter.size() >= elements + kSlack) return;
    const std::size_t room = 2 * (std::size_t{elements} + kSlack);
    enter.resize(room);
    exit.resize(room);
    state.resize(room);
    what.resize(room);
  }
  void append(float enter_t, float exit_t, float state_of, std::uint32_t what_it_is) {
    enter[size] = enter_t;
    exit[size] = exit_t;
    state[size] = state_of;
    what[size] = what_it_is;
    ++size;
  }
};

/// Nodes to visit, the next one last.
struct WalkStack {
  std::vector<float> enter = std::vector<float>(256);
  std::vector<float> exit = std::vector<float>(256);
  std::vector<std::uint32_t> what = std::vector<std::uint32_t>(256);
  std::uint32_t size = 0;

  void reserve_children() {
    if (size + 16 <= enter.size()) return;
    enter.resize(2 * enter.size());
    exit.resize(enter.size());
    what.resize(enter.size());
  }
};

/// What the vector instructions work on.
struct WalkState {
  WalkList known;  ///< of the rounds before
  WalkList next;   ///< of this round
  WalkStack stack;
  std::uint32_t position = 0;  ///< in `known`: the next element
  float t_min = 0.0f, t_last = 0.0f, t_max = 0.0f;
  std::uint64_t repeated_internal = 0, repeated_leaves = 0;  ///< visits of nodes known before
  std::uint32_t pushed_at = 0;                               ///< place in the stack of the first child pushed last
  std::uint32_t sticking_out = 0;  ///< mask of those pushed last: children that begin before `bound`
};

struct WalkKernels {
  /// Copies elements of `known` to `next`, without those that end before t_min, and counts those that are visited, up
  /// to the first that needs attention: visited, and open, guarded, or a hit in [t_last, t_max]. That one is not
  /// copied. False: none is left.
  bool (*scan)(WalkState& walk);
  /// Tests the children of the internal node at `address` (units), and pushes those hit. bound: the largest entry t of
  /// the node and those above it; exit: the least exit.
  void (*open)(WalkState& walk, const NodeImage& image, std::uint32_t address, const SlabRay& ray, float bound,
               float exit);
};

/// Puts the children pushed last, which stand in their order but for nearly equal entry t, in their order.
void sort_pushed(WalkState& walk);

/// For nodes of a layout. The path must be available.
WalkKernels walk_kernels(SimdPath path, const InternalLayout& layout);

}  // namespace grtx::frontend
