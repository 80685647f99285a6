// SPDX-License-Identifier: Apache-2.0
// The structure that rays are traced in: that of one scene, or a world of several objects.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/accel/multi_object.h"
#include "grtx/frontend/gaussian/prepared_gaussians.h"
#include "grtx/frontend/scene/scene.h"

namespace grtx::frontend {

/// All that it refers to must outlive it.
struct TracedStructure {
  TracedStructure(const Scene& s, const PreparedGaussians& g, const AccelerationStructure& accel)
      : scene(s),
        gaussians(g),
        image(accel.image()),
        options(accel.options()),
        proxy(accel.proxy()),
        patches(accel.patches()),
        offset(s.offset),
        root(static_cast<std::uint32_t>(accel.root() / image.sizes().unit())),
        blas_root(static_cast<std::uint32_t>(accel.blas_root() / image.sizes().unit())) {}
  explicit TracedStructure(const MultiObjectWorld& w)
      : scene(w.objects().front()->scene),
        gaussians(w.objects().front()->gaussians),
        image(w.image()),
        options(w.options()),
        proxy(w.proxy()),
        patches(w.patches()),
        offset(w.offset()),
        root(static_cast<std::uint32_t>(w.root() / image.sizes().unit())),
        blas_root(static_cast<std::uint32_t>(w.blas_root() / image.sizes().unit())),
        world(&w) {}

  const Scene& scene;                  ///< with several objects: of the first
  const PreparedGaussians& gaussians;  ///< likewise
  const NodeImage& image;
  const AccelOptions& options;
  const Proxy& proxy;
  const FacePatches& patches;
  glm::dvec3 offset;        ///< scene coordinates + offset = world coordinates
  std::uint32_t root;       ///< units
  std::uint32_t blas_root;  ///< units; 0: none
  const MultiObjectWorld* world = nullptr;
};

}  // namespace grtx::frontend
