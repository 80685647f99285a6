// SPDX-License-Identifier: Apache-2.0
// Replays one ray of a trace for the page of `grtx ray`: its nodes, and the initial state and events of each round,
// packed so that the page's script can show all lists after every event. docs/guide/ray.md describes the page. What
// check_group() does not hold a trace to and the page relies on is tested here: Error with file, place and rule.
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

namespace grtx::report {

inline constexpr std::uint32_t kNoGaussian = ~std::uint32_t{0};

/// A node that a ray visited, or a child of one.
struct RayNode {
  std::uint32_t units = 0;  ///< address in units of the node layout
  traces::NodeKind kind = traces::NodeKind::internal;
  std::uint32_t parent = 0;       ///< node number + 1; 0: a root
  std::uint32_t first_child = 0;  ///< node number + 1; siblings follow in slot order; 0: not visited, or a leaf
  /// Gaussian of an instance or primitive leaf, kNoGaussian if unknown. For a leaf of a scene TLAS: number of the first
  /// Gaussian of its object.
  std::uint32_t gaussian = kNoGaussian;
  // Only if the scene is given.
  bool boxed = false;
  std::array<float, 6> box{};  ///< lower x, y, z, upper x, y, z; inside a BLAS in the unit sphere's frame
};

/// The nodes of the chosen rays of a group, numbered from 0.
class RayNodes {
 public:
  /// Throws Error if two nodes of the group have one child: the nodes are no tree. `file`: the trace.
  RayNodes(const std::string& file, const traces::Header& header, const traces::RayGroup& group,
           const std::vector<unsigned>& lanes);

  std::vector<RayNode>& nodes() { return nodes_; }
  const std::vector<RayNode>& nodes() const { return nodes_; }
  std::uint32_t number(std::uint32_t units) const { return numbers_.at(units); }

 private:
  bool add(std::uint32_t units, traces::NodeKind kind, std::uint32_t parent);

  std::vector<RayNode> nodes_;
  std::map<std::uint32_t, std::uint32_t> numbers_;
};

/// Values of a ray that a trace does not contain, recorded by tracing it again (frontend/tracer/ray_watch.h).
struct RayValues {
  std::vector<float> t_max;                                              ///< [event] after the event
  std::vector<float> times;                                              ///< as WatchedRay::times
  std::vector<float> start_t_max;                                        ///< [round] at its start
  std::vector<std::vector<std::pair<float, std::uint32_t>>> start_hits;  ///< [round] (t, Gaussian) in k-buffer
  std::vector<float> transmittance;                                      ///< [round] after the round
  std::array<float, 3> origin{}, direction{};
};

/// One round of a ray.
struct RayRound {
  traces::Round round;
  std::uint32_t visits[3] = {};                         ///< internal nodes, instance leaves, primitive leaves
  std::uint32_t culls = 0;                              ///< nodes popped but not fetched
  std::uint32_t outcomes[8] = {};                       ///< leaf visits by traces::LeafOutcome
  std::uint32_t written = 0, taken = 0, forwarded = 0;  ///< checkpoint entries
  std::uint32_t blended = 0;
  std::uint32_t evictions_left = 0;  ///< in the eviction buffer after the k-buffer is filled
  /// State and events for report/ray/web/ray.js; format: ray_replay.cpp.
  std::vector<std::uint8_t> packed;
};

struct ReplayedRay {
  std::vector<RayRound> rounds;
  std::set<std::uint32_t> met;                    ///< numbers of Gaussians hit; only with values
  std::map<std::uint32_t, std::uint32_t> learnt;  ///< node number -> Gaussian, as far as the trace determines it
};

/// values: null without the scene, and always with Header::ahead above 1. The group must have passed
/// traces::check_group(). With `ahead` above 1 events stand in the order in which the ray came to them. Throws Error if
/// the ray's k-buffer cannot be replayed; std::logic_error if the values belong to another ray.
ReplayedRay replay_ray(const std::string& file, const traces::Header& header, const traces::RayGroup& group,
                       unsigned lane, const RayNodes& nodes, const RayValues* values);

}  // namespace grtx::report
