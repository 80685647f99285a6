// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/camera/readers.h"

#include <nlohmann/json.hpp>

#include "grtx/base/atomic_file.h"
#include "grtx/base/json.h"
#include "grtx/frontend/camera/json_fields.h"

namespace grtx::frontend {
namespace {

Camera read_entry(const JsonObject& entry, std::size_t index) {
  Camera camera;
  camera.name = entry.has("img_name") ? entry.text("img_name") : "camera_" + std::to_string(index);
  camera.width = entry.pixels("width");
  camera.height = entry.pixels("height");
  const std::vector<double> position = entry.numbers("position", 3);
  camera.position = {position[0], position[1], position[2]};
  const std::vector<double> rotation = entry.matrix("rotation", 3, 3);
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      camera.rotation[static_cast<glm::length_t>(column)][static_cast<glm::length_t>(row)] = rotation[row * 3 + column];
    }
  }
  camera.cx = entry.has("cx") ? entry.number("cx") : 0.5 * camera.width;
  camera.cy = entry.has("cy") ? entry.number("cy") : 0.5 * camera.height;
  if (entry.has("projection")) {
    const std::string projection = entry.text("projection");
    if (projection == "fisheye") {
      camera.projection = Projection::fisheye;
      camera.fisheye_fov = entry.number("fisheye_fov");
    } else if (projection != "pinhole") {
      entry.fail("\"projection\" must be \"pinhole\" or \"fisheye\"");
    }
  }
  const bool spans_image = camera.projection == Projection::fisheye && camera.fisheye_fov > 0.0;
  camera.fx = spans_image && !entry.has("fx") ? camera.width / camera.fisheye_fov : entry.number("fx");
  camera.fy = spans_image && !entry.has("fy") ? camera.height / camera.fisheye_fov : entry.number("fy");
  check_camera(camera, entry.file, entry.place);
  return camera;
}

}  // namespace

std::vector<Camera> read_cameras_json(const nlohmann::json& json, const std::string& file) {
  std::vector<Camera> cameras;
  for (std::size_t i = 0; i < json.size(); ++i) {
    cameras.push_back(read_entry(JsonObject{json[i], file, "camera " + std::to_string(i)}, i));
  }
  return cameras;
}

void write_cameras_json(const std::string& path, const std::vector<Camera>& cameras) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Camera& camera = cameras[i];
    nlohmann::ordered_json entry;
    entry["id"] = i;
    entry["img_name"] = camera.name;
    entry["width"] = camera.width;
    entry["height"] = camera.height;
    entry["position"] = {camera.position.x, camera.position.y, camera.position.z};
    nlohmann::ordered_json rotation = nlohmann::ordered_json::array();
    for (glm::length_t row = 0; row < 3; ++row) {
      rotation.push_back({camera.rotation[0][row], camera.rotation[1][row], camera.rotation[2][row]});
    }
    entry["rotation"] = std::move(rotation);
    const bool fisheye = camera.projection == Projection::fisheye;
    entry["fy"] = fisheye && camera.fy == 0.0 ? camera.height / camera.fisheye_fov : camera.fy;
    entry["fx"] = fisheye && camera.fx == 0.0 ? camera.width / camera.fisheye_fov : camera.fx;
    // The 3DGS layout has no principal point: it is the image's middle.
    if (camera.cx != 0.5 * camera.width) entry["cx"] = camera.cx;
    if (camera.cy != 0.5 * camera.height) entry["cy"] = camera.cy;
    if (fisheye) {
      entry["projection"] = "fisheye";
      entry["fisheye_fov"] = camera.fisheye_fov;
    }
    list.push_back(std::move(entry));
  }
  write_file(path, json_text(list, 1) + "\n");
}

}  // namespace grtx::frontend
