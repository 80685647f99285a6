// SPDX-License-Identifier: Apache-2.0
// Replays one ray of a trace for the page of `grtx ray`: the lists as each round begins, and what each event changes in
// them. docs/guide/ray.md describes the page. What check_group() does not hold a trace to and the page relies on is
// tested here: Error with file, place and rule.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "grtx/report/ray/ray_nodes.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::report {

/// Values of a ray that a trace does not contain, recorded by tracing it again (frontend/tracer/ray_watch.h).
struct RayValues {
  std::vector<float> t_max;        ///< after each event, in the order in which the ray came to them
  std::vector<float> times;        ///< as WatchedRay::times
  std::vector<float> start_t_max;  ///< [round] at its start
  std::vector<std::vector<std::pair<float, std::uint32_t>>> start_hits;  ///< [round] (t, Gaussian) in k-buffer
  std::vector<float> transmittance;                                      ///< [round] after the round
  std::array<float, 3> origin{}, direction{};
};

/// One round of a ray.
struct RayRound {
  traces::Round round;
  std::uint32_t visits[3] = {};                         ///< internal nodes, instance leaves, primitive leaves
  std::uint32_t outcomes[8] = {};                       ///< leaf visits by traces::LeafOutcome
  std::uint32_t written = 0, taken = 0, forwarded = 0;  ///< checkpoint entries
  std::uint32_t blended = 0;
  /// The lists, and what events change in them: packed_round.h.
  std::vector<std::uint8_t> packed;
};

struct ReplayedRay {
  std::vector<RayRound> rounds;
  std::set<std::uint32_t> met;                    ///< numbers of Gaussians hit; only with values
  std::map<std::uint32_t, std::uint32_t> learnt;  ///< node number -> Gaussian, as far as the trace determines it
};

/// values: null without the scene. The group must have passed traces::check_group(). With Header::ahead above 1 events
/// stand in the order in which the ray came to them. Throws Error if
/// the ray's k-buffer cannot be replayed; std::logic_error if the values belong to another ray.
ReplayedRay replay_ray(const std::string& file, const traces::Header& header, const traces::RayGroup& group,
                       unsigned lane, const RayNodes& nodes, const RayValues* values);

}  // namespace grtx::report
