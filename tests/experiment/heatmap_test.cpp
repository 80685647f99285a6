// SPDX-License-Identifier: Apache-2.0
// The picture of a heat map says where its largest values are.
#include "grtx/experiment/heatmap.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace grtx::experiment {
namespace {

constexpr glm::vec3 kMark(0.2f, 0.95f, 1.0f);

std::size_t marks_in(const frontend::Image& image) {
  return static_cast<std::size_t>(std::ranges::count(image.pixels, kMark));
}

// Nothing in the picture told which pixel was slow: no axes, no marks.
TEST(HeatmapPicture, MarksAValueOncePerWarpAndNoMoreThanTen) {
  Heatmap map{"cycles", "", 64, 32, std::vector<double>(64 * 32, 0.0)};
  const std::size_t nothing = marks_in(draw_heatmap(map));
  EXPECT_EQ(nothing, 0U);
  for (std::size_t i = 0; i < 32; ++i) map.values[i] = 5.0;  // the rays of one warp
  const std::size_t one = marks_in(draw_heatmap(map));
  EXPECT_GT(one, 4U * 8);  // a frame and its number
  map.values[700] = 9.0;
  EXPECT_GT(marks_in(draw_heatmap(map)), one);
  for (std::size_t i = 0; i < 40; ++i) map.values[40 * i + 20] = 10.0 + static_cast<double>(i);
  const std::size_t ten = marks_in(draw_heatmap(map));
  map.values[41] = 1.0;  // smaller than ten others
  EXPECT_EQ(marks_in(draw_heatmap(map)), ten);
}

// "1 at 24,40" without its cycles, and a bar that mixed 1.31e+06 with 983038.5.
TEST(HeatmapPicture, TheSlowestPlacesHaveTheirValues) {
  const auto list = [](double second) {
    Heatmap map{"cycles", "of a ray's warp", 64, 32, std::vector<double>(64 * 32, 0.0)};
    map.values[100] = 1310718.0;
    map.values[700] = second;
    const frontend::Image image = draw_heatmap(map);
    return std::vector(image.pixels.end() - std::ptrdiff_t{30} * image.width, image.pixels.end());
  };
  EXPECT_NE(list(983038.0), list(983039.0));
  EXPECT_EQ(list(983038.0), list(983038.4));
}

TEST(HeatmapPicture, HasRoomForAxesAndListWhateverTheSize) {
  for (const auto& [width, height] : {std::pair(1u, 1u), std::pair(3u, 200u), std::pair(500u, 2u)}) {
    const Heatmap map{"visits", "of a ray", width, height, std::vector<double>(std::size_t{width} * height, 1.0)};
    const frontend::Image image = draw_heatmap(map);
    EXPECT_GT(image.width, width);
    EXPECT_GT(image.height, height);
    EXPECT_GT(marks_in(image), 0U);
  }
}

}  // namespace
}  // namespace grtx::experiment
