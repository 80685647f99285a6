// SPDX-License-Identifier: Apache-2.0
#include "grtx/base/files_read.h"
#include "grtx/frontend/camera/readers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <numbers>

#include "grtx/base/error.h"

namespace grtx::frontend {
namespace {

struct Model {
  const char* name;
  std::size_t parameters;     // doubles in the file
  std::size_t focal_lengths;  // 1 or 2 of them first, then cx, cy, then distortion
};

// By model id.
constexpr std::array<Model, 7> kModels{{{"SIMPLE_PINHOLE", 3, 1},
                                        {"PINHOLE", 4, 2},
                                        {"SIMPLE_RADIAL", 4, 1},
                                        {"RADIAL", 5, 1},
                                        {"OPENCV", 8, 2},
                                        {"OPENCV_FISHEYE", 8, 2},
                                        {"FULL_OPENCV", 12, 2}}};
constexpr std::size_t kFisheyeModel = 5;

// Little-endian numbers from a file's bytes; every read is checked.
class ByteReader {
 public:
  ByteReader(std::string path, FilesRead& files) : path_(std::move(path)), bytes_(files.read(path_)) {}

  template <typename T>
  T next() {
    require(sizeof(T));
    T value;
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  std::string next_text() {
    const std::size_t end = bytes_.find('\0', at_);
    if (end == std::string::npos) fail("a name must end in a zero byte; the file ends first");
    std::string text = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    return text;
  }
  void skip(std::uint64_t count, std::size_t bytes_each) {
    if (count > (bytes_.size() - at_) / bytes_each) fail("the file ends within an entry");
    at_ += static_cast<std::size_t>(count) * bytes_each;
  }
  void require_end() const {
    if (at_ != bytes_.size()) fail("has " + std::to_string(bytes_.size() - at_) + " bytes behind its last entry");
  }
  [[noreturn]] void fail(const std::string& rule) const { throw Error(path_, place(), rule); }
  std::string place() const { return "byte " + std::to_string(at_); }
  const std::string& path() const { return path_; }

 private:
  void require(std::size_t count) const {
    if (bytes_.size() - at_ < count) fail("the file ends within an entry");
  }

  std::string path_;
  std::string bytes_;
  std::size_t at_ = 0;
};

std::map<std::int32_t, Camera> read_intrinsics(const std::string& path, FilesRead& files) {
  ByteReader in(path, files);
  std::map<std::int32_t, Camera> cameras;
  const auto count = in.next<std::uint64_t>();
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto id = in.next<std::int32_t>();
    const auto model_id = in.next<std::int32_t>();
    if (model_id < 0 || static_cast<std::size_t>(model_id) >= kModels.size()) {
      in.fail("camera " + std::to_string(id) + " has the model " + std::to_string(model_id) + "; supported are 0 to 6");
    }
    const Model& model = kModels[static_cast<std::size_t>(model_id)];
    Camera camera;
    const auto width = in.next<std::uint64_t>();
    const auto height = in.next<std::uint64_t>();
    // Sizes beyond what check_camera() allows become 0, which it refuses.
    camera.width = width <= 65536 ? static_cast<unsigned>(width) : 0;
    camera.height = height <= 65536 ? static_cast<unsigned>(height) : 0;
    camera.fx = in.next<double>();
    camera.fy = model.focal_lengths == 2 ? in.next<double>() : camera.fx;
    camera.cx = in.next<double>();
    camera.cy = in.next<double>();
    for (std::size_t p = model.focal_lengths + 2; p < model.parameters; ++p) {
      if (in.next<double>() != 0.0) {
        in.fail("camera " + std::to_string(id) + " (" + model.name +
                ") has lens distortion, which is not supported: undistort the images first");
      }
    }
    if (static_cast<std::size_t>(model_id) == kFisheyeModel) {
      camera.projection = Projection::fisheye;
      camera.fisheye_fov = 2.0 * std::numbers::pi;  // every pixel up to 180 degrees off axis has a ray
    }
    check_camera(camera, in.path(), in.place());
    if (!cameras.emplace(id, camera).second) in.fail("has the camera id " + std::to_string(id) + " twice");
  }
  in.require_end();
  return cameras;
}

// Rows of the world-to-camera rotation, which are the columns of camera to world.
glm::dmat3 camera_to_world(double w, double x, double y, double z) {
  const glm::dvec3 right(1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y));
  const glm::dvec3 down(2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x));
  const glm::dvec3 forward(2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y));
  return glm::dmat3(right, down, forward);
}

Camera read_image_entry(ByteReader& in, const std::map<std::int32_t, Camera>& intrinsics) {
  in.next<std::int32_t>();  // image id
  std::array<double, 4> q{};
  for (double& component : q) component = in.next<double>();
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(norm > 1e-12) || !std::isfinite(norm)) in.fail("the rotation's quaternion must be finite and not zero");
  for (double& component : q) component /= norm;
  glm::dvec3 translation;
  for (glm::length_t axis = 0; axis < 3; ++axis) translation[axis] = in.next<double>();
  const auto camera_id = in.next<std::int32_t>();
  const auto found = intrinsics.find(camera_id);
  if (found == intrinsics.end()) in.fail("names the camera " + std::to_string(camera_id) + ", which cameras.bin lacks");
  Camera camera = found->second;
  camera.name = in.next_text();
  camera.rotation = camera_to_world(q[0], q[1], q[2], q[3]);
  camera.position = -(camera.rotation * translation);  // -R^T t
  check_camera(camera, in.path(), in.place());
  const auto points = in.next<std::uint64_t>();
  in.skip(points, 2 * sizeof(double) + sizeof(std::int64_t));
  return camera;
}

std::filesystem::path model_folder(const std::filesystem::path& folder) {
  for (const char* below : {"", "sparse/0", "sparse", "0"}) {
    std::filesystem::path candidate = folder / below;
    if (std::filesystem::exists(candidate / "cameras.bin") && std::filesystem::exists(candidate / "images.bin")) {
      return candidate;
    }
  }
  throw Error(folder.string(), "", "a COLMAP folder must hold cameras.bin and images.bin (also below sparse/0)");
}

}  // namespace

std::vector<Camera> read_colmap(const std::string& folder, FilesRead& files) {
  const std::filesystem::path model = model_folder(folder);
  const std::map<std::int32_t, Camera> intrinsics = read_intrinsics((model / "cameras.bin").string(), files);
  ByteReader in((model / "images.bin").string(), files);
  std::vector<Camera> cameras;
  const auto count = in.next<std::uint64_t>();
  for (std::uint64_t i = 0; i < count; ++i) cameras.push_back(read_image_entry(in, intrinsics));
  in.require_end();
  if (cameras.empty()) in.fail("has no images");
  std::sort(cameras.begin(), cameras.end(), [](const Camera& a, const Camera& b) { return a.name < b.name; });
  return cameras;
}

}  // namespace grtx::frontend
