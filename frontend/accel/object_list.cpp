// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/accel/object_list.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "grtx/base/error.h"
#include "grtx/base/files_read.h"
#include "grtx/base/json.h"
#include "grtx/frontend/camera/json_fields.h"

namespace grtx::frontend {

bool is_object_list(const std::string& path) {
  const std::filesystem::path name = std::filesystem::path(path).filename();
  return name.extension() == ".json" && name != "meta.json" && name != "lod-meta.json";  // SOG scenes
}

ObjectList load_object_list(const std::string& path) {
  FilesRead files;
  return load_object_list(path, files);
}

ObjectList load_object_list(const std::string& path, FilesRead& files) {
  const nlohmann::json json = parse_json<nlohmann::json>(files.read(path), path);
  if (!json.is_array() || json.empty()) throw Error(path, "", "must be a list of at least one object");
  static const std::set<std::string> kKeys = {"file", "translate", "rotate", "scale"};
  ObjectList list;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const JsonObject entry{json[i], path, "object " + std::to_string(i)};
    if (!entry.json.is_object()) entry.fail("must be a JSON object");
    for (const auto& [key, value] : entry.json.items()) {
      if (!kKeys.contains(key)) entry.fail("key \"" + key + "\" is unknown");
    }
    std::filesystem::path file = entry.text("file");
    if (file.is_relative()) file = std::filesystem::path(path).parent_path() / file;
    const auto known = std::find(list.files.begin(), list.files.end(), file.string());
    Placement placement;
    placement.object = static_cast<unsigned>(known - list.files.begin());
    if (known == list.files.end()) list.files.push_back(file.string());
    if (entry.has("translate")) {
      const std::vector<double> t = entry.numbers("translate", 3);
      placement.translate = {t[0], t[1], t[2]};
    }
    if (entry.has("rotate")) {
      const std::vector<double> q = entry.numbers("rotate", 4);
      const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
      if (!(length > 0.0 && std::isfinite(length))) entry.fail("\"rotate\" must be a quaternion w, x, y, z, not null");
      placement.rotate = glm::dquat(q[0] / length, q[1] / length, q[2] / length, q[3] / length);
    }
    if (entry.has("scale")) placement.scale = entry.number("scale");
    if (!(placement.scale > 0.0 && std::isfinite(placement.scale))) entry.fail("\"scale\" must be positive");
    list.placements.push_back(placement);
  }
  return list;
}

}  // namespace grtx::frontend
