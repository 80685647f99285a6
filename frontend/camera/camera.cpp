// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/camera/camera.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <numbers>

#include "grtx/base/error.h"
#include "grtx/base/files_read.h"
#include "grtx/base/hash.h"
#include "grtx/base/json.h"
#include "grtx/frontend/camera/json_fields.h"
#include "grtx/frontend/camera/readers.h"

namespace grtx::frontend {

Camera Camera::resized(unsigned new_width, unsigned new_height) const {
  if (new_width == 0 || new_height == 0 || width == 0 || height == 0) {
    throw Error("camera " + name, "", "width and height must be at least 1 pixel");
  }
  const double x = static_cast<double>(new_width) / static_cast<double>(width);
  const double y = static_cast<double>(new_height) / static_cast<double>(height);
  Camera result = *this;
  result.width = new_width;
  result.height = new_height;
  result.fx *= x;
  result.cx *= x;
  result.fy *= y;
  result.cy *= y;
  return result;
}

Camera Camera::fov_scaled(double factor) const {
  if (!std::isfinite(factor) || factor <= 0.0) {
    throw Error("camera " + name, "", "the field of view's factor must be positive and finite");
  }
  Camera result = *this;
  result.fov_scale *= factor;
  result.fx /= factor;
  result.fy /= factor;
  // An equidistant fisheye is linear in the angle itself.
  result.fisheye_fov = std::min(fisheye_fov * factor, 2.0 * std::numbers::pi);
  return result;
}

Camera Camera::as_fisheye(double fov) const {
  if (!(fov > 0.0 && fov <= 2.0 * std::numbers::pi)) {
    throw Error("camera " + name, "", "the fisheye's field of view must be above 0 and at most 2 pi radians");
  }
  Camera result = *this;
  result.projection = Projection::fisheye;
  result.fisheye_fov = fov;
  result.fx = static_cast<double>(width) / fov;
  result.fy = static_cast<double>(height) / fov;
  return result;
}

glm::dvec3 Camera::direction(unsigned x, unsigned y) const {
  const double right = static_cast<double>(x) + 0.5 - cx;  // pixels
  const double down = static_cast<double>(y) + 0.5 - cy;
  if (projection == Projection::pinhole) return glm::normalize(rotation * glm::dvec3(right / fx, down / fy, 1.0));
  const double a = right / (fx > 0.0 ? fx : static_cast<double>(width) / fisheye_fov);  // radians
  const double b = down / (fy > 0.0 ? fy : static_cast<double>(height) / fisheye_fov);
  const double theta = std::sqrt(a * a + b * b);
  if (theta > 0.5 * fisheye_fov) return glm::dvec3(0.0);
  // sin(theta) / theta tends to 1 on the axis.
  const double side = theta > 0.0 ? std::sin(theta) / theta : 1.0;
  return glm::normalize(rotation * glm::dvec3(a * side, b * side, std::cos(theta)));
}

std::uint64_t Camera::hash() const {
  std::vector<double> numbers = {static_cast<double>(width),
                                 static_cast<double>(height),
                                 position.x,
                                 position.y,
                                 position.z,
                                 fx,
                                 fy,
                                 cx,
                                 cy,
                                 fisheye_fov,
                                 static_cast<double>(projection)};
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) numbers.push_back(rotation[column][row]);
  }
  for (double& number : numbers) number += 0.0;  // -0 becomes 0
  return xxh3(numbers.data(), numbers.size() * sizeof(double));
}

std::vector<Camera> load_cameras(const std::string& path) {
  FilesRead files;
  return load_cameras(path, files);
}

std::vector<Camera> load_cameras(const std::string& path, FilesRead& files) {
  if (std::filesystem::is_directory(path)) return read_colmap(path, files);
  const nlohmann::json json = parse_json<nlohmann::json>(files.read(path), path);
  std::vector<Camera> cameras =
      json.is_array() ? read_cameras_json(json, path) : read_transforms_json(json, path, files);
  if (cameras.empty()) throw Error(path, "", "has no cameras");
  return cameras;
}

}  // namespace grtx::frontend
