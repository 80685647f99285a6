// SPDX-License-Identifier: Apache-2.0
// The tracer's blended Gaussians against the fp64 reference's: a difference must be one that tiny changes of t, d or
// alpha explain, and the smallest such changes are reported.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <vector>

#include "grtx/frontend/reference/reference.h"

namespace grtx::test {

/// The smallest changes of the reference's numbers under which the exact algorithm blends what the tracer blended.
struct Explanation {
  double t = 0.0;       ///< of two hits' t that came in the other order, or of an entry before or behind the origin;
                        ///< relative to the largest |t| at which the two proxies are left
  double radius = 0.0;  ///< of d / kappa at the proxy's limit 1
  double alpha = 0.0;   ///< of 255 alpha at the limit 1
  double transmittance = 0.0;  ///< relative, at the limit where a ray ends
  void take(const Explanation& o) {
    t = std::max(t, o.t);
    radius = std::max(radius, o.radius);
    alpha = std::max(alpha, o.alpha);
    transmittance = std::max(transmittance, o.transmittance);
  }
};

/// traced: ids in blending order. candidates: the reference's, of the same ray. An id that the reference does not even
/// nearly meet has no explanation: infinite radius.
inline Explanation explain(const std::vector<std::uint32_t>& traced,
                           const std::vector<frontend::ReferenceCandidate>& candidates, double ert) {
  using frontend::ReferenceCandidate;
  Explanation result;
  std::unordered_map<std::uint32_t, const ReferenceCandidate*> by_id;
  for (const ReferenceCandidate& c : candidates) by_id[c.gaussian] = &c;
  const auto scale = [](const ReferenceCandidate& a, const ReferenceCandidate& b) {
    return std::max({std::abs(a.exit), std::abs(b.exit), std::abs(a.t), std::abs(b.t)});
  };
  // What the tracer blended must nearly be a hit, and come nearly in order.
  const ReferenceCandidate* farthest = nullptr;
  double transmittance = 1.0;
  double before_last = 1.0;
  for (const std::uint32_t id : traced) {
    const auto found = by_id.find(id);
    if (found == by_id.end()) {
      result.radius = std::numeric_limits<double>::infinity();
      return result;
    }
    const ReferenceCandidate& c = *found->second;
    by_id.erase(found);
    if (!c.hit) {
      result.radius = std::max(result.radius, c.radius - 1.0);
      result.alpha = std::max(result.alpha, 1.0 - 255.0 * c.alpha);
      result.t = std::max(result.t, -c.entry / scale(c, c));
    }
    if (farthest != nullptr && c.t < farthest->t) {
      result.t = std::max(result.t, (farthest->t - c.t) / scale(c, *farthest));
    }
    if (farthest == nullptr || c.t > farthest->t) farthest = &c;
    before_last = transmittance;
    transmittance *= 1.0 - c.alpha;
  }
  // It must not have gone on too long.
  if (!traced.empty() && before_last < ert) {
    result.transmittance = std::max(result.transmittance, (ert - before_last) / ert);
  }
  // What it left out must lie behind an end by transmittance, or nearly be no hit.
  for (const auto& [id, c] : by_id) {
    if (!c->hit) continue;
    const double near_miss = std::min({1.0 - c->radius, 255.0 * c->alpha - 1.0, c->entry / scale(*c, *c)});
    double behind = std::numeric_limits<double>::infinity();
    if (farthest != nullptr) {
      behind = std::max(0.0, (farthest->t - c->t) / scale(*c, *farthest));
      behind = std::max(behind, (transmittance - ert) / ert);
    }
    if (behind <= near_miss) {
      result.t = std::max(result.t, std::max(0.0, (farthest->t - c->t) / scale(*c, *farthest)));
      result.transmittance = std::max(result.transmittance, (transmittance - ert) / ert);
    } else if (near_miss == 1.0 - c->radius) {
      result.radius = std::max(result.radius, near_miss);
    } else if (near_miss == 255.0 * c->alpha - 1.0) {
      result.alpha = std::max(result.alpha, near_miss);
    } else {
      result.t = std::max(result.t, near_miss);
    }
  }
  return result;
}

struct Parity {
  std::size_t rays = 0;
  std::size_t different = 0;  ///< rays that blend something else, or in another order
  Explanation needed;         ///< the largest over all different rays
};

inline Parity compare_sequences(const std::vector<std::vector<std::uint32_t>>& traced,
                                const frontend::ReferenceResult& exact, double ert) {
  Parity parity;
  parity.rays = traced.size();
  for (std::size_t p = 0; p < traced.size(); ++p) {
    const auto& expected = exact.sequences[p];
    const bool same =
        std::equal(traced[p].begin(), traced[p].end(), expected.begin(), expected.end(),
                   [](std::uint32_t id, const frontend::ReferenceHit& hit) { return id == hit.gaussian; });
    if (same) continue;
    ++parity.different;
    parity.needed.take(explain(traced[p], exact.candidates[p], ert));
  }
  return parity;
}

}  // namespace grtx::test
