// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/camera/readers.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <numbers>

#include "grtx/base/error.h"

namespace grtx::frontend {
namespace {

constexpr unsigned kMaxSide = 65536;  // pixels
constexpr double kTolerance = 1e-3;   // on each entry of R^T R; single-precision files stay far below

/// In fp32, as rays have it.
bool is_finite(const glm::dvec3& v) {
  const glm::vec3 rounded(v);
  return std::isfinite(rounded.x) && std::isfinite(rounded.y) && std::isfinite(rounded.z);
}

}  // namespace

void check_camera(const Camera& camera, const std::string& file, const std::string& place) {
  const auto require = [&](bool holds, const char* rule) {
    if (!holds) throw Error(file, place, rule);
  };
  require(camera.width >= 1 && camera.width <= kMaxSide && camera.height >= 1 && camera.height <= kMaxSide,
          "width and height must be 1 to 65536 pixels");
  require(is_finite(camera.position), "the position must be finite in fp32");
  require(std::isfinite(camera.fx) && std::isfinite(camera.fy) && camera.fx > 0.0 && camera.fy > 0.0,
          "the focal lengths must be positive and finite");
  require(std::isfinite(camera.cx) && std::isfinite(camera.cy), "the principal point must be finite");
  const glm::dmat3 product = glm::transpose(camera.rotation) * camera.rotation;
  for (glm::length_t column = 0; column < 3; ++column) {
    for (glm::length_t row = 0; row < 3; ++row) {
      const double expected = column == row ? 1.0 : 0.0;
      require(std::abs(product[column][row] - expected) <= kTolerance,  // also false for NaN
              "the rotation must be orthonormal within 1e-3");
    }
  }
  require(glm::determinant(camera.rotation) > 0.0, "the rotation must not be a mirror image (negative determinant)");
  if (camera.projection == Projection::fisheye) {
    require(camera.fisheye_fov > 0.0 && camera.fisheye_fov <= 2.0 * std::numbers::pi,
            "the fisheye's field of view must be above 0 and at most 2 pi radians");
  }
}

}  // namespace grtx::frontend
