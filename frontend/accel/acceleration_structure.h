// SPDX-License-Identifier: Apache-2.0
// The acceleration structures under comparison: monolithic BVHs over proxies, and a TLAS over one shared BLAS.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "grtx/frontend/accel/accel_options.h"
#include "grtx/frontend/accel/node_image.h"
#include "grtx/frontend/gaussian/prepared_gaussians.h"
#include "grtx/frontend/gaussian/proxy.h"
#include "grtx/traces/modes.h"

namespace grtx::frontend {

ProxyKind proxy_of(AccelKind kind);
/// Bytes that a structure takes while it is built, with `leaves` primitive leaves per Gaussian. Measured
/// (docs/guide/scenes.md).
std::uint64_t bytes_to_build(AccelKind kind, std::size_t gaussians, std::size_t leaves);

class AccelerationStructure {
 public:
  /// gaussians: quantised if the layout is.
  AccelerationStructure(const PreparedGaussians& gaussians, const AccelOptions& options);

  const AccelOptions& options() const { return options_; }
  const Proxy& proxy() const { return proxy_; }
  const FacePatches& patches() const { return patches_; }
  const NodeImage& image() const { return image_; }
  bool two_level() const { return is_two_level(options_.kind); }
  std::uint64_t root() const { return root_; }                ///< byte address of the (TLAS) root, an internal node
  std::uint64_t blas_header() const { return blas_header_; }  ///< 0 when monolithic
  std::uint64_t blas_root() const { return blas_root_; }      ///< 0 when monolithic; an internal node

  struct Counts {
    std::uint64_t internal = 0, instance = 0, triangle = 0, procedural = 0, blas_nodes = 0;
    std::uint64_t wide = 0;  ///< wide leaves among instances and procedural leaves
  };
  const Counts& counts() const { return counts_; }
  unsigned height() const { return height_; }              ///< levels of the monolithic BVH or the TLAS
  unsigned blas_height() const { return blas_height_; }    ///< 0 when monolithic
  double build_seconds() const { return build_seconds_; }  ///< rtcBuildBVH alone
  double pack_seconds() const { return pack_seconds_; }    ///< encoding the node image

 private:
  using IsWide = std::function<bool(std::uint32_t primitive)>;  ///< which leaves are wide; null: none
  void build_monolithic(const PreparedGaussians& gaussians, std::size_t leaves, const IsWide& is_wide);
  void build_two_level(const PreparedGaussians& gaussians, std::size_t leaves, const IsWide& is_wide);

  AccelOptions options_;
  Proxy proxy_;
  FacePatches patches_;
  NodeImage image_;
  std::uint64_t root_ = 0;
  std::uint64_t blas_header_ = 0;
  std::uint64_t blas_root_ = 0;
  Counts counts_;
  unsigned height_ = 0;
  unsigned blas_height_ = 0;
  double build_seconds_ = 0.0;
  double pack_seconds_ = 0.0;
};

}  // namespace grtx::frontend
