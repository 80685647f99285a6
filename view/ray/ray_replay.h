// Replays one ray of a trace for a page: its nodes, and of each round what it began with and its events, packed so that
// the page's script can follow every list after every event. docs/guide/ray.md says what a reader sees.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::sim {

inline constexpr std::uint32_t kNoGaussian = ~std::uint32_t{0};

/// A node that rays visited, or a child of one.
struct RayNode {
  std::uint32_t units = 0;  ///< address
  traces::NodeKind kind = traces::NodeKind::internal;
  std::uint32_t parent = 0;       ///< number + 1; 0: a root
  std::uint32_t first_child = 0;  ///< number + 1; children follow in slot order; 0: not visited, or a leaf
  /// Gaussian of an instance or primitive leaf, where it is known. For a leaf of a scene TLAS: the number that its
  /// object's Gaussians begin with.
  std::uint32_t gaussian = kNoGaussian;
  // Where the scene is given.
  bool boxed = false;
  std::array<float, 6> box{};  ///< low, high; of a BLAS in the unit sphere's frame
};

/// The nodes of some rays of a group, each under a number.
class RayNodes {
 public:
  RayNodes(const traces::Header& header, const traces::RayGroup& group, const std::vector<unsigned>& lanes);

  std::vector<RayNode>& nodes() { return nodes_; }
  const std::vector<RayNode>& nodes() const { return nodes_; }
  std::uint32_t number(std::uint32_t units) const { return numbers_.at(units); }

 private:
  void add(std::uint32_t units, traces::NodeKind kind, std::uint32_t parent);

  std::vector<RayNode> nodes_;
  std::map<std::uint32_t, std::uint32_t> numbers_;
};

/// What a trace does not hold of a ray, from who traced it again (frontend/tracer/ray_watch.h).
struct RayValues {
  std::vector<float> t_max;                                              ///< after each event
  std::vector<float> times;                                              ///< as WatchedRay::times
  std::vector<float> start_t_max;                                        ///< of each round
  std::vector<std::vector<std::pair<float, std::uint32_t>>> start_hits;  ///< (t, Gaussian) in each round's k-buffer
  std::vector<float> transmittance;                                      ///< after each round
  std::array<float, 3> origin{}, direction{};
};

/// One round of a ray.
struct RayRound {
  traces::Round round;
  std::uint32_t visits[3] = {};                         ///< internal nodes, instance leaves, primitive leaves
  std::uint32_t culls = 0;                              ///< popped, not fetched
  std::uint32_t outcomes[8] = {};                       ///< of leaves, by traces::LeafOutcome
  std::uint32_t written = 0, taken = 0, forwarded = 0;  ///< checkpoint entries
  std::uint32_t blended = 0;
  std::uint32_t evictions_left = 0;  ///< in the eviction buffer when the round begins
  /// view/ray/web/ray.js reads it: docs in ray_replay.cpp.
  std::vector<std::uint8_t> packed;
};

struct ReplayedRay {
  std::vector<RayRound> rounds;
  std::set<std::uint32_t> met;                    ///< Gaussians that were hit, by number; only with values
  std::map<std::uint32_t, std::uint32_t> learnt;  ///< node -> its Gaussian, as the trace tells
};

/// values: null where only the trace is known. The group must obey the rules of a trace (traces::check_group).
/// Throws std::logic_error when the values are not of this ray.
ReplayedRay replay_ray(const traces::Header& header, const traces::RayGroup& group, unsigned lane,
                       const RayNodes& nodes, const RayValues* values);

}  // namespace grtx::sim
