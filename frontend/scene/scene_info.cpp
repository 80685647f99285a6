// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/scene/scene_info.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "grtx/base/json.h"

namespace grtx::frontend {
namespace {

constexpr double kOuterShare = 0.001;  // share of the centres at both ends together
constexpr double kExtentSigmas = 3.0;

// Sorted values at a share of 0 .. 1 of their ranks, linear in between.
double quantile(const std::vector<double>& sorted, double share) {
  if (sorted.empty()) return 0.0;
  const double rank = share * static_cast<double>(sorted.size() - 1);
  const std::size_t below = static_cast<std::size_t>(rank);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  const double t = rank - static_cast<double>(below);
  return sorted[below] * (1.0 - t) + sorted[above] * t;
}

Percentiles percentiles(std::vector<double>& values) {
  std::sort(values.begin(), values.end());
  Percentiles result{};
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = quantile(values, kInfoPercentiles[i] / 100.0);
  return result;
}

void describe_centres(const Scene& scene, SceneInfo& info) {
  FileBox all, inner;
  std::vector<double> values(scene.size());
  for (glm::length_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < scene.size(); ++i) {
      values[i] = static_cast<double>(scene.mean[i][axis]) + scene.offset[axis];
    }
    std::sort(values.begin(), values.end());
    all.low[axis] = values.front();
    all.high[axis] = values.back();
    inner.low[axis] = quantile(values, 0.5 * kOuterShare);
    inner.high[axis] = quantile(values, 1.0 - 0.5 * kOuterShare);
  }
  info.centres = all;
  info.inner_centres = inner;
}

void describe_extent(const Scene& scene, SceneInfo& info) {
  FileBox box{glm::dvec3(std::numeric_limits<double>::infinity()),
              glm::dvec3(-std::numeric_limits<double>::infinity())};
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const glm::dmat3 rotation = glm::mat3_cast(glm::dquat(scene.rotation[i]));
    const glm::dvec3 scale(scene.scale[i]);
    for (glm::length_t axis = 0; axis < 3; ++axis) {
      // Half the ellipsoid's width along an axis: norm of that row of rotation * diag(scale).
      double squares = 0.0;
      for (glm::length_t column = 0; column < 3; ++column) {
        const double entry = rotation[column][axis] * scale[column];
        squares += entry * entry;
      }
      const double centre = static_cast<double>(scene.mean[i][axis]) + scene.offset[axis];
      const double half = kExtentSigmas * std::sqrt(squares);
      box.low[axis] = std::min(box.low[axis], centre - half);
      box.high[axis] = std::max(box.high[axis], centre + half);
    }
  }
  info.extent = box;
}

void describe_scales(const Scene& scene, SceneInfo& info) {
  std::vector<double> largest, middle, smallest, ratio;
  for (const glm::vec3& scale : scene.scale) {
    std::array<double, 3> sorted{scale.x, scale.y, scale.z};
    std::sort(sorted.begin(), sorted.end());
    smallest.push_back(sorted[0]);
    middle.push_back(sorted[1]);
    largest.push_back(sorted[2]);
    ratio.push_back(sorted[2] / sorted[0]);
  }
  info.scale_max = percentiles(largest);
  info.scale_mid = percentiles(middle);
  info.scale_min = percentiles(smallest);
  info.scale_ratio = percentiles(ratio);
}

std::string box_text(const std::optional<FileBox>& box) {
  if (!box) return "none (empty scene)";
  return fmt::format("({:.5g}, {:.5g}, {:.5g}) to ({:.5g}, {:.5g}, {:.5g})", box->low.x, box->low.y, box->low.z,
                     box->high.x, box->high.y, box->high.z);
}

std::string percentiles_text(const char* what, const Percentiles& values) {
  std::string line = fmt::format("{:<15}", what);
  for (const double value : values) line += fmt::format(" {:>8.4g}", value);
  return line + "\n";
}

std::string reasons_text(const char* kind, const std::map<std::string, std::uint64_t>& reasons) {
  if (reasons.empty()) return fmt::format("{:<20} nothing\n", kind);
  std::string lines;
  for (const auto& [reason, count] : reasons) lines += fmt::format("{:<20} {:>10}  {}\n", kind, count, reason);
  return lines;
}

nlohmann::ordered_json to_array(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

nlohmann::ordered_json to_object(const std::optional<FileBox>& box) {
  if (!box) return nullptr;
  return {{"low", to_array(box->low)}, {"high", to_array(box->high)}};
}

nlohmann::ordered_json to_object(const Percentiles& values) {
  nlohmann::ordered_json object = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < values.size(); ++i) object[fmt::format("p{}", kInfoPercentiles[i])] = values[i];
  return object;
}

}  // namespace

SceneInfo describe(const Scene& scene) {
  SceneInfo info;
  info.name = scene.name;
  info.hash = scene.hash;
  info.gaussians = scene.size();
  info.sh_degree = scene.sh_degree;
  info.offset = scene.offset;
  info.report = scene.report;
  for (const float opacity : scene.opacity) {
    ++info.opacity_tenths[std::min<std::size_t>(9, static_cast<std::size_t>(static_cast<double>(opacity) * 10.0))];
  }
  if (scene.size() == 0) return info;
  describe_centres(scene, info);
  describe_extent(scene, info);
  describe_scales(scene, info);
  return info;
}

std::string to_text(const SceneInfo& info) {
  std::string text;
  text += fmt::format("{:<20} {}\n", "scene", info.name);
  text += fmt::format("{:<20} {}\n", "hash (XXH3)", info.hash);
  text += fmt::format("{:<20} {} of {} rows\n", "Gaussians", info.gaussians, info.report.rows);
  text += fmt::format("{:<20} {}\n", "SH degree", info.sh_degree);
  text += fmt::format("{:<20} {}\n", "centres", box_text(info.centres));
  text += fmt::format("{:<20} {}\n", "without outer 0.1 %", box_text(info.inner_centres));
  text += fmt::format("{:<20} {}\n", "extent at 3 sigma", box_text(info.extent));
  text += fmt::format("{:<20} ({:.9g}, {:.9g}, {:.9g})\n", "offset", info.offset.x, info.offset.y, info.offset.z);
  text += fmt::format("{:<15}", "percentile");  // 78 columns
  for (const double p : kInfoPercentiles) text += fmt::format(" {:>8}", p);
  text += "\n";
  text += percentiles_text("largest scale", info.scale_max);
  text += percentiles_text("middle scale", info.scale_mid);
  text += percentiles_text("smallest scale", info.scale_min);
  text += percentiles_text("scale ratio", info.scale_ratio);
  for (std::size_t i = 0; i < info.opacity_tenths.size(); ++i) {
    const double share =
        info.gaussians == 0 ? 0.0
                            : 100.0 * static_cast<double>(info.opacity_tenths[i]) / static_cast<double>(info.gaussians);
    text += fmt::format(
        "{:<20} {:>10}  {:5.1f} %\n",
        fmt::format("opacity {:.1f} .. {:.1f}", 0.1 * static_cast<double>(i), 0.1 * static_cast<double>(i + 1)),
        info.opacity_tenths[i], share);
  }
  text += reasons_text("dropped", info.report.dropped);
  text += reasons_text("clamped", info.report.clamped);
  text += reasons_text("noticed", info.report.noticed);
  return text;
}

std::string to_json(const SceneInfo& info) {
  nlohmann::ordered_json json;
  json["schema"] = "grtx.info/1";
  json["name"] = info.name;
  json["hash"] = info.hash;
  json["rows"] = info.report.rows;
  json["gaussians"] = info.gaussians;
  json["sh_degree"] = info.sh_degree;
  json["offset"] = to_array(info.offset);
  json["boxes"] = {{"centres", to_object(info.centres)},
                   {"inner_centres", to_object(info.inner_centres)},
                   {"extent_3_sigma", to_object(info.extent)}};
  json["scale"] = {{"max", to_object(info.scale_max)},
                   {"mid", to_object(info.scale_mid)},
                   {"min", to_object(info.scale_min)},
                   {"ratio", to_object(info.scale_ratio)}};
  json["opacity_tenths"] = info.opacity_tenths;
  json["dropped"] = info.report.dropped;
  json["clamped"] = info.report.clamped;
  json["noticed"] = info.report.noticed;
  // A file's name may contain bytes that are not UTF-8.
  return json_text(json, 2) + "\n";
}

}  // namespace grtx::frontend
