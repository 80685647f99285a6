// SPDX-License-Identifier: Apache-2.0
// Heat map of one number per pixel: a PNG in false colours with a colour bar, and the values as EXR.
#pragma once

#include <string>
#include <vector>

#include "grtx/frontend/image/image.h"

namespace grtx::experiment {

struct Heatmap {
  std::string name;  ///< name of the counts
  std::string unit;  ///< added to the name in the title
  unsigned width = 0, height = 0;
  std::vector<double> values;  ///< row by row, the top one first; not negative
};

/// Parsed --heatmap option: "NAME=PATH.png", or "NAME", which writes NAME.png.
struct HeatmapRequest {
  std::string name;
  std::string path;
};
/// Path of the PNG of a request, and of the EXR written beside a PNG.
std::string heatmap_path(const std::string& request);
std::string heatmap_values_path(const std::string& picture);
/// Throws Error for an unknown name or a path that is not a .png.
std::vector<HeatmapRequest> heatmap_requests(const std::vector<std::string>& texts,
                                             const std::vector<std::string>& names);

/// Colour of a value between 0 (black) and 1 (pale yellow); lightness increases monotonically.
glm::vec3 heat_colour(double value);
/// The picture with title, pixel numbers at its edges and colour bar, from 0 to the largest value. The ten largest
/// values are marked and listed. Small maps are enlarged by whole factors.
frontend::Image draw_heatmap(const Heatmap& map);
/// Writes `path` (.png) and, beside it, the same name with .exr: all three channels hold the value, as 32-bit floats.
void write_heatmap(const std::string& path, const Heatmap& map);

}  // namespace grtx::experiment
