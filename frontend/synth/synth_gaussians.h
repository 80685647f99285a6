// SPDX-License-Identifier: Apache-2.0
// Draws the Gaussians of a generated world, each from its index alone.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/frontend/scene/ply_writer.h"
#include "grtx/frontend/synth/synth.h"
#include "grtx/frontend/synth/synth_colour.h"
#include "grtx/frontend/synth/synth_world.h"

namespace grtx::frontend {

class SynthGaussians {
 public:
  SynthGaussians(SynthWorld world, const SynthOptions& options);
  /// Row `index` of the file. Rows are in random order, like those of a trained scene.
  PlyRow row(std::uint64_t index) const;

 private:
  struct Part {
    SynthPatch patch;
    std::uint64_t first = 0;  ///< generation index (before the rows are shuffled) of its first Gaussian
    std::uint64_t count = 0;
    std::uint64_t leaves = 0;
    double spacing = 0.0;    ///< expected distance to the 8th neighbour
    double log_reach = 0.0;  ///< ln of the largest scale that still fits on the patch
  };

  void allocate(std::uint64_t surface_rows);
  PlyRow surface_row(std::uint64_t generation) const;
  struct SurfaceSize {
    std::array<double, 3> log_scales{};  ///< from the largest to the smallest
    glm::dvec3 along_rim{0.0};           ///< direction of the rim that the largest axis would cross; 0: it crosses none
  };
  SurfaceSize surface_size(const Part& part, const glm::dvec3& at, double size_score, double lies_flat,
                           CounterRandom& random) const;
  void colour_surface(PlyRow& row, const Part& part, const SynthPoint& point, const std::array<double, 3>& log_scales,
                      CounterRandom& random) const;
  PlyRow shell_row(std::uint64_t generation) const;
  PlyRow far_row(std::uint64_t generation) const;
  /// Directions from the cameras to the point: cameras in front of the surface first, nearest first.
  std::vector<glm::dvec3> views_of(const SynthPoint& point) const;
  float opacity_logit(double size_score, double lies_flat, double shift, CounterRandom& random) const;

  SynthWorld world_;
  SynthOptions options_;
  CounterPermutation order_;
  SynthColourNoise noise_;
  std::vector<Part> parts_;
  std::uint64_t surface_ = 0, shell_ = 0, far_ = 0;
};

}  // namespace grtx::frontend
