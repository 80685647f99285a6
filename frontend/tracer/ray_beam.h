// SPDX-License-Identifier: Apache-2.0
// The rays of a group as one: intervals of their origins and reciprocal directions. One slab test with them says of a
// box that none of the rays meets it, or that some may. docs/model/numerics.md has the proof.
#pragma once

#include "grtx/frontend/accel/node_image.h"
#include "grtx/frontend/gaussian/slab_intersection.h"

namespace grtx::frontend {

class RayBeam {
 public:
  void clear() { *this = {}; }
  void add(const SlabRay& ray) {
    for (int i = 0; i < 3; ++i) {
      Axis& axis = axes_[i];
      if (!empty_ && axis.negative != ray.negative[i]) axis.mixed = true;
      axis.negative = ray.negative[i];
      axis.first_origin = empty_ ? ray.origin[i] : std::min(axis.first_origin, ray.origin[i]);
      axis.last_origin = empty_ ? ray.origin[i] : std::max(axis.last_origin, ray.origin[i]);
      axis.least_inverse = empty_ ? ray.inverse[i] : std::min(axis.least_inverse, ray.inverse[i]);
      axis.most_inverse = empty_ ? ray.inverse[i] : std::max(axis.most_inverse, ray.inverse[i]);
    }
    empty_ = false;
  }

  /// Whether some ray may meet the box at t >= 0. False: the conservative_interval() of each ray with it is empty or
  /// ends before 0.
  bool meets(const Box& box) const {
    if (empty_) return false;
    float enter = -std::numeric_limits<float>::infinity();
    float exit = std::numeric_limits<float>::infinity();
    for (int i = 0; i < 3; ++i) {
      const Axis& axis = axes_[i];
      if (axis.mixed) continue;  // the rays spread over both directions: this axis says nothing
      // A bound's distance lies between those from the two outermost origins. Its product with a reciprocal is least
      // and most at the ends of both intervals, which the signs tell.
      if (axis.negative) {
        const float near = box.upper[i] - axis.first_origin, far = box.lower[i] - axis.last_origin;
        enter = std::max(enter, near * (near >= 0.0f ? axis.least_inverse : axis.most_inverse));
        exit = std::min(exit, far * (far >= 0.0f ? axis.most_inverse : axis.least_inverse));
      } else {
        const float near = box.lower[i] - axis.last_origin, far = box.upper[i] - axis.first_origin;
        enter = std::max(enter, near * (near >= 0.0f ? axis.least_inverse : axis.most_inverse));
        exit = std::min(exit, far * (far >= 0.0f ? axis.most_inverse : axis.least_inverse));
      }
    }
    const float last = exit * (1.0f + kSlabSlack);
    return std::max(enter, 0.0f) * (1.0f - kSlabSlack) <= last && last >= 0.0f;
  }
  /// Mask of the children of a decoded internal node whose box it meets.
  unsigned met(const DecodedInternal& node) const {
    unsigned mask = 0;
    for (unsigned slot = 0; slot < node.child_count; ++slot) mask |= (meets(node.boxes[slot]) ? 1U : 0U) << slot;
    return mask;
  }

 private:
  struct Axis {
    bool negative = false, mixed = false;
    float first_origin = 0.0f, last_origin = 0.0f;
    float least_inverse = 0.0f, most_inverse = 0.0f;
  };
  Axis axes_[3];
  bool empty_ = true;
};

}  // namespace grtx::frontend
