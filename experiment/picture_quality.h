// SPDX-License-Identifier: Apache-2.0
// How far the pictures of each design are from those of the design that speed-ups are over, and from the fp64 reference
// in the design's own order: a design that blends in another order, or with rounded Gaussians, draws another picture.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "grtx/experiment/tracer_settings.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/scene/scene.h"
#include "grtx/frontend/tracer/tracer_options.h"

namespace grtx::experiment {

/// One design's pictures; of each frame in dB, infinite where the pictures are identical.
struct PictureQuality {
  std::string order;              ///< by which its hits are blended
  bool fp64 = true;               ///< compared with the fp64 reference; else with the tracer at full precision
  std::uint64_t pixels = 0;       ///< of a frame that were compared with it
  std::vector<double> over;       ///< against the design that speed-ups are over, all pixels
  std::vector<double> reference;  ///< against the reference in the design's order
};

/// {"order", "reference": "fp64" or "tracer", "reference_pixels", "psnr": [...], "psnr_reference": [...]}, by frame;
/// null: identical.
nlohmann::ordered_json picture_json(const PictureQuality& quality);

/// The least of a list of picture_json() as text: "36.0 dB", or "identical".
std::string worst_picture(const nlohmann::ordered_json& decibels);

/// dB on these pixels, all if there are none; infinite for identical pixels, 0 where a value is no number in one alone.
double psnr_on(const frontend::Image& image, const frontend::Image& reference, const std::vector<std::size_t>& pixels);

/// Pictures by the fp64 reference on tiles spread over the frame, 48 x 48 pixels in all; of large scenes fewer.
class ReferencePictures {
 public:
  /// Most pairs of a ray and a Gaussian of a picture; with glass or mirror, whose rays leave the cone of their tile.
  static constexpr std::uint64_t kMostPairs = std::uint64_t{1} << 34, kMostPairsOfObjects = std::uint64_t{1} << 29;
  static constexpr unsigned kMostTilesASide = 6;

  /// scene: as it was read; nullptr: no reference (several objects). It must live as long as new orders are asked for.
  ReferencePictures(const frontend::Scene* scene, const std::vector<frontend::Camera>& cameras, bool quiet)
      : scene_(scene), cameras_(cameras), quiet_(quiet) {}

  struct Frames {
    std::vector<frontend::Image> images;
    std::vector<std::size_t> pixels;  ///< of each that the reference has rendered
  };
  /// The frames as this design orders its hits; none where the reference would take too long.
  const Frames& frames(const TracerSettings& settings, frontend::AccelKind accel);

  /// Tiles along a side for a scene of so many Gaussians; 0: too many of them.
  static unsigned tiles_per_side(std::uint64_t gaussians, std::uint64_t most_pairs);

 private:
  const frontend::Scene* scene_;
  std::vector<frontend::Camera> cameras_;
  bool quiet_;
  std::map<std::pair<int, int>, Frames> frames_;  ///< by proxy and sort key
};

}  // namespace grtx::experiment
