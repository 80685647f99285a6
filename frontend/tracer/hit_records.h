// SPDX-License-Identifier: Apache-2.0
// A hit's Gaussian and its alpha, for the shader that blends it.
#pragma once

#include <cstdint>

#include "grtx/frontend/gaussian/gaussian_math.h"
#include "grtx/frontend/gaussian/response_precision.h"
#include "grtx/frontend/tracer/k_buffer.h"
#include "grtx/frontend/tracer/traced_structure.h"
#include "grtx/frontend/tracer/tracer_options.h"

namespace grtx::frontend {

class HitRecords {
 public:
  HitRecords(const TracedStructure& structure, const TracerOptions& options)
      : gaussians_(structure.gaussians),
        world_(structure.world),
        precision_(options.response_precision),
        degree_(options.kernel.degree) {}

  const GaussianRecord& of(std::uint32_t id) const {
    return world_ != nullptr ? world_->record(id) : gaussians_.record(id);
  }
  /// The Gaussian's number in a trace: that of its record, which placements of one file share.
  std::uint32_t number(std::uint32_t id) const { return world_ != nullptr ? world_->record_number(id) : id; }
  /// 0 when the hit does not count.
  float alpha(const KEntry& hit, const GaussianRecord& g) const {
    return precision_ == ResponsePrecision::fp32 ? hit_alpha(g.opacity, g.kappa2, hit.d2, degree_)
                                                 : hit_alpha_16(g.opacity, g.kappa2, hit.d2, precision_, degree_);
  }

 private:
  const PreparedGaussians& gaussians_;
  const MultiObjectWorld* const world_;
  const ResponsePrecision precision_;
  const unsigned degree_;
};

}  // namespace grtx::frontend
