// SPDX-License-Identifier: Apache-2.0
// Cameras and primary rays. Internal convention: right, down, forward; pixel centres at +0.5.
#pragma once

#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace grtx {
class FilesRead;
}

namespace grtx::frontend {

enum class Projection { pinhole, fisheye };

struct Camera {
  std::string name;
  unsigned width = 0, height = 0;                 ///< pixels
  glm::dvec3 position{0.0};                       ///< camera centre in file coordinates (before recentring)
  glm::dmat3 rotation{1.0};                       ///< camera to world; columns are right, down, forward
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;  ///< pixels; fisheye: fx, fy per radian (0: see fisheye_fov)
  Projection projection = Projection::pinhole;    ///< fisheye: equidistant, theta = r * fov / 2 with r = 1 at the edge
  double fov_scale = 1.0;    ///< product of all fov_scaled() factors; fx, fy and fisheye_fov include it
  double fisheye_fov = 0.0;  ///< radians, full angle; no ray beyond; with fx, fy = 0 it spans the image

  /// The same view at another resolution: focal lengths and centre scale per axis, so both fields of view are kept.
  Camera resized(unsigned new_width, unsigned new_height) const;
  /// Field of view multiplied by `factor` (tangent of the half angle), for --fov-scale.
  Camera fov_scaled(double factor) const;
  /// The same view through an equidistant fisheye whose full angle `fov` (radians) spans width and height.
  Camera as_fisheye(double fov) const;
  /// Unit direction in world space through the centre of pixel (x, y), double precision; zero vector when the
  /// projection has no ray there (outside the fisheye circle).
  glm::dvec3 direction(unsigned x, unsigned y) const;

  /// Hash of all that determines the rays, so not of the name: cameras of one hash see the same.
  std::uint64_t hash() const;
};

/// 3DGS cameras.json, NeRF transforms.json, or a COLMAP binary folder. Throws Error{file, place, rule}.
std::vector<Camera> load_cameras(const std::string& path);
/// files: every file that is opened is noted there; of pictures only the header, which gives their size.
std::vector<Camera> load_cameras(const std::string& path, FilesRead& files);

/// Writes 3DGS cameras.json.
void write_cameras_json(const std::string& path, const std::vector<Camera>& cameras);

}  // namespace grtx::frontend
