// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/camera/readers.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>

#include "grtx/frontend/camera/json_fields.h"

namespace grtx::frontend {
namespace {

// Reads width and height, big-endian at bytes 16 and 20 of a PNG. False when the file is missing or not a PNG.
bool png_size(const std::filesystem::path& path, unsigned& width, unsigned& height, FilesRead& files) {
  if (!std::filesystem::is_regular_file(path)) return false;
  std::FILE* file = std::fopen(path.c_str(), "rb");
  if (file == nullptr) return false;
  unsigned char head[24] = {};
  const bool complete = std::fread(head, 1, sizeof(head), file) == sizeof(head);
  std::fclose(file);
  files.note(path.string(), {reinterpret_cast<const char*>(head), sizeof(head)});
  if (!complete || head[0] != 0x89 || head[1] != 'P' || head[2] != 'N' || head[3] != 'G') return false;
  const auto big_endian = [&head](int at) {
    return unsigned{head[at]} << 24 | unsigned{head[at + 1]} << 16 | unsigned{head[at + 2]} << 8 | head[at + 3];
  };
  width = big_endian(16);
  height = big_endian(20);
  return true;
}

// Value of a key in the frame, else in the whole file.
const JsonObject& holder(const JsonObject& frame, const JsonObject& all, const char* key) {
  return frame.has(key) ? frame : all;
}

void read_size(Camera& camera, const JsonObject& frame, const JsonObject& all, FilesRead& files) {
  const bool given = holder(frame, all, "w").has("w") && holder(frame, all, "h").has("h");
  if (given) {
    camera.width = holder(frame, all, "w").pixels("w");
    camera.height = holder(frame, all, "h").pixels("h");
    return;
  }
  std::filesystem::path image = std::filesystem::path(frame.file).parent_path() / camera.name;
  if (image.extension() != ".png") image += ".png";  // file_path usually leaves the extension out
  if (!png_size(image, camera.width, camera.height, files)) {
    frame.fail("needs \"w\" and \"h\", or its image as PNG beside the file");
  }
}

void read_focal_lengths(Camera& camera, const JsonObject& frame, const JsonObject& all) {
  const auto number = [&](const char* key) { return holder(frame, all, key).number(key); };
  const auto has = [&](const char* key) { return holder(frame, all, key).has(key); };
  if (has("fl_x")) {
    camera.fx = number("fl_x");
  } else if (has("camera_angle_x")) {
    camera.fx = 0.5 * camera.width / std::tan(0.5 * number("camera_angle_x"));
  } else {
    frame.fail("needs the key \"fl_x\" or \"camera_angle_x\"");
  }
  camera.fy = has("fl_y") ? number("fl_y") : camera.fx;  // square pixels
  camera.cx = has("cx") ? number("cx") : 0.5 * camera.width;
  camera.cy = has("cy") ? number("cy") : 0.5 * camera.height;
}

void read_projection(Camera& camera, const JsonObject& frame, const JsonObject& all) {
  for (const char* key : {"k1", "k2", "k3", "k4", "p1", "p2"}) {
    const JsonObject& from = holder(frame, all, key);
    if (from.has(key) && from.number(key) != 0.0) {
      frame.fail("lens distortion is not supported: \"" + std::string(key) + "\" must be 0");
    }
  }
  const JsonObject& model = holder(frame, all, "camera_model");
  const JsonObject& flag = holder(frame, all, "is_fisheye");
  bool fisheye = flag.has("is_fisheye") && flag.json["is_fisheye"] == true;
  if (model.has("camera_model")) {
    const std::string name = model.text("camera_model");
    if (name == "OPENCV_FISHEYE") {
      fisheye = true;
    } else if (name != "OPENCV" && name != "PINHOLE" && name != "SIMPLE_PINHOLE") {
      frame.fail("the camera model \"" + name + "\" is not supported");
    }
  }
  if (!fisheye) return;
  camera.projection = Projection::fisheye;
  camera.fisheye_fov = 2.0 * std::numbers::pi;  // every pixel up to 180 degrees off axis has a ray
}

Camera read_frame(const JsonObject& frame, const JsonObject& all, std::size_t index, FilesRead& files) {
  Camera camera;
  camera.name = frame.has("file_path") ? frame.text("file_path") : "frame_" + std::to_string(index);
  const std::vector<double> pose = frame.matrix("transform_matrix", 3, 4);
  // OpenGL axes are right, up, back: the second and third column change sign.
  for (std::size_t row = 0; row < 3; ++row) {
    const auto r = static_cast<glm::length_t>(row);
    camera.rotation[0][r] = pose[row * 4];
    camera.rotation[1][r] = -pose[row * 4 + 1];
    camera.rotation[2][r] = -pose[row * 4 + 2];
    camera.position[r] = pose[row * 4 + 3];
  }
  read_size(camera, frame, all, files);
  read_focal_lengths(camera, frame, all);
  read_projection(camera, frame, all);
  check_camera(camera, frame.file, frame.place);
  return camera;
}

}  // namespace

std::vector<Camera> read_transforms_json(const nlohmann::json& json, const std::string& file, FilesRead& files) {
  const JsonObject all{json, file, ""};
  if (!json.is_object() || !all.has("frames") || !json["frames"].is_array()) {
    all.fail("must be an array of cameras (3DGS) or an object with an array \"frames\" (NeRF)");
  }
  std::vector<Camera> cameras;
  const nlohmann::json& frames = json["frames"];
  for (std::size_t i = 0; i < frames.size(); ++i) {
    cameras.push_back(read_frame(JsonObject{frames[i], file, "frame " + std::to_string(i)}, all, i, files));
  }
  return cameras;
}

}  // namespace grtx::frontend
