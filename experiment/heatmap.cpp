// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/heatmap.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <numeric>

#include "grtx/base/error.h"
#include "grtx/base/nearest_name.h"
#include "grtx/experiment/pixel_font.h"

namespace grtx::experiment {
namespace {

constexpr unsigned kSmallest = 384;  // pixels of the longer side of the map in the picture
constexpr unsigned kMargin = 8, kTextScale = 2, kBarWidth = 20, kTicks = 5;
constexpr unsigned kLine = kGlyphHeight * kTextScale + kMargin / 2;
constexpr std::size_t kMarks = 10;
constexpr glm::vec3 kMark(0.2f, 0.95f, 1.0f);  // far from all heat colours
constexpr glm::vec3 kBackground(0.12f), kInk(0.92f);

void fill(frontend::Image& image, unsigned x, unsigned y, unsigned width, unsigned height, const glm::vec3& colour) {
  for (unsigned j = y; j < std::min(image.height, y + height); ++j) {
    for (unsigned i = x; i < std::min(image.width, x + width); ++i) image.at(i, j) = colour;
  }
}

unsigned text_width(const std::string& text) { return static_cast<unsigned>(text.size()) * kGlyphAdvance * kTextScale; }

void draw_text(frontend::Image& image, unsigned x, unsigned y, const std::string& text, const glm::vec3& ink = kInk) {
  for (const char c : text) {
    const auto rows = glyph(c);
    for (unsigned row = 0; row < kGlyphHeight; ++row) {
      for (unsigned column = 0; column < kGlyphWidth; ++column) {
        if ((rows[row] >> (kGlyphWidth - 1 - column) & 1) == 0) continue;
        fill(image, x + column * kTextScale, y + row * kTextScale, kTextScale, kTextScale, ink);
      }
    }
    x += kGlyphAdvance * kTextScale;
  }
}

std::string label(double value) {
  if (value >= 1e9) return fmt::format("{:.3g}", value);
  return fmt::format("{:.{}f}", value, value == std::floor(value) || value >= 1e3 ? 0 : 1);
}

/// Pixels of the largest values, one per value: rays of a warp share theirs.
std::vector<std::size_t> largest_pixels(const Heatmap& map) {
  std::vector<std::size_t> order(map.values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::greater(), [&](std::size_t pixel) { return map.values[pixel]; });
  std::vector<std::size_t> largest;
  for (const std::size_t pixel : order) {
    if (largest.size() == kMarks || !(map.values[pixel] > 0.0)) break;
    if (largest.empty() || map.values[pixel] != map.values[largest.back()]) largest.push_back(pixel);
  }
  return largest;
}

/// Pixel numbers below and left of a map whose corner is at x, y.
void draw_axes(frontend::Image& image, const Heatmap& map, unsigned x, unsigned y, unsigned zoom) {
  for (unsigned tick = 0; tick + 1 < kTicks; ++tick) {
    const unsigned column = tick * (map.width - 1) / (kTicks - 2), row = tick * (map.height - 1) / (kTicks - 2);
    const std::string across = std::to_string(column), down = std::to_string(row);
    const unsigned at_x = x + column * zoom + zoom / 2, at_y = y + row * zoom + zoom / 2;
    fill(image, at_x, y + map.height * zoom, 1, kMargin / 2, kInk);
    fill(image, x - kMargin / 2, at_y, kMargin / 2, 1, kInk);
    draw_text(image, at_x - std::min(at_x, text_width(across) / 2), y + map.height * zoom + kMargin / 2 + 2, across);
    draw_text(image, x - kMargin / 2 - text_width(down), at_y - std::min(at_y, kGlyphHeight * kTextScale / 2), down);
  }
}

/// A frame around a pixel, and its number.
void draw_mark(frontend::Image& image, unsigned x, unsigned y, unsigned zoom, const std::string& number) {
  const unsigned left = x < 2 ? 0 : x - 2, top = y < 2 ? 0 : y - 2, side = zoom + 4;
  fill(image, left, top, side, 2, kMark);
  fill(image, left, top + side - 2, side, 2, kMark);
  fill(image, left, top, 2, side, kMark);
  fill(image, left + side - 2, top, 2, side, kMark);
  draw_text(image, left + side + 1, top, number, kMark);
}

}  // namespace

std::string heatmap_path(const std::string& request) {
  const std::size_t equals = request.find('=');
  return equals == std::string::npos ? request + ".png" : request.substr(equals + 1);
}

std::string heatmap_values_path(const std::string& picture) {
  return std::filesystem::path(picture).replace_extension(".exr").string();
}

std::vector<HeatmapRequest> heatmap_requests(const std::vector<std::string>& texts,
                                             const std::vector<std::string>& names) {
  std::vector<HeatmapRequest> requests;
  for (const std::string& text : texts) {
    const HeatmapRequest request{text.substr(0, text.find('=')), heatmap_path(text)};
    if (std::find(names.begin(), names.end(), request.name) == names.end()) {
      throw Error("--heatmap", request.name, "is unknown; the nearest is " + nearest_name(request.name, names));
    }
    if (!request.path.ends_with(".png")) throw Error("--heatmap", request.path, "must be a .png");
    requests.push_back(request);
  }
  return requests;
}

glm::vec3 heat_colour(double value) {
  // Black, violet, red, orange, pale yellow, in equal steps of lightness.
  static constexpr std::array<glm::vec3, 6> kStops = {glm::vec3(0.0f, 0.0f, 0.02f),   glm::vec3(0.27f, 0.05f, 0.43f),
                                                      glm::vec3(0.62f, 0.12f, 0.41f), glm::vec3(0.90f, 0.34f, 0.19f),
                                                      glm::vec3(0.99f, 0.69f, 0.15f), glm::vec3(0.99f, 1.0f, 0.75f)};
  const double position = std::clamp(value, 0.0, 1.0) * static_cast<double>(kStops.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(position), kStops.size() - 2);
  const auto part = static_cast<float>(position - static_cast<double>(below));
  return kStops[below] * (1.0f - part) + kStops[below + 1] * part;
}

frontend::Image draw_heatmap(const Heatmap& map) {
  const double largest = map.values.empty() ? 0.0 : *std::max_element(map.values.begin(), map.values.end());
  const double scale = largest > 0.0 ? 1.0 / largest : 0.0;
  const unsigned longer = std::max(1u, std::max(map.width, map.height));
  const unsigned zoom = std::max(1u, (kSmallest + longer - 1) / longer);
  const unsigned map_width = map.width * zoom, map_height = std::max(map.height * zoom, 12 * kGlyphHeight * kTextScale);
  const unsigned top = 2 * kMargin + kGlyphHeight * kTextScale;
  const std::string title = map.name + " " + map.unit + ", largest " + label(largest);
  const std::vector<std::size_t> marked = largest_pixels(map);
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < marked.size(); ++i) {
    lines.push_back(fmt::format("{} at {},{}  {}", i + 1, marked[i] % map.width, marked[i] / map.width,
                                label(map.values[marked[i]])));
  }
  const unsigned left = kMargin + text_width(std::to_string(std::max(1u, map.height) - 1)) + kMargin / 2;
  const unsigned bar_x = left + map_width + 2 * kMargin;
  const unsigned labels_x = bar_x + kBarWidth + kMargin;
  const unsigned width = std::max(labels_x + text_width(label(largest) + "00"), 2 * kMargin + text_width(title));
  const unsigned list_y = top + map_height + kMargin / 2 + kLine + kMargin / 2;
  frontend::Image image(width, list_y + kLine * static_cast<unsigned>(lines.size()) + kMargin / 2);
  fill(image, 0, 0, image.width, image.height, kBackground);
  draw_text(image, kMargin, kMargin, title);
  for (unsigned y = 0; y < map.height; ++y) {
    for (unsigned x = 0; x < map.width; ++x) {
      const double value = map.values[std::size_t{y} * map.width + x];
      fill(image, left + x * zoom, top + y * zoom, zoom, zoom, heat_colour(value * scale));
    }
  }
  if (map.width > 0 && map.height > 0) draw_axes(image, map, left, top, zoom);
  for (std::size_t i = 0; i < marked.size(); ++i) {
    const auto x = static_cast<unsigned>(marked[i] % map.width), y = static_cast<unsigned>(marked[i] / map.width);
    draw_mark(image, left + x * zoom, top + y * zoom, zoom, std::to_string(i + 1));
  }
  for (std::size_t i = 0; i < lines.size(); ++i) {
    draw_text(image, kMargin, list_y + kLine * static_cast<unsigned>(i), lines[i]);
  }
  for (unsigned y = 0; y < map_height; ++y) {
    fill(image, bar_x, top + y, kBarWidth, 1, heat_colour(1.0 - static_cast<double>(y) / (map_height - 1)));
  }
  for (unsigned tick = 0; tick < kTicks; ++tick) {
    const double part = static_cast<double>(tick) / (kTicks - 1);
    const auto y = top + static_cast<unsigned>(std::lround((1.0 - part) * (map_height - 1)));
    fill(image, bar_x + kBarWidth, y, kMargin / 2, 1, kInk);
    const unsigned text_y =
        std::min(y < kGlyphHeight ? 0 : y - kGlyphHeight, top + map_height - kGlyphHeight * kTextScale);
    draw_text(image, labels_x, std::max(text_y, top), label(part * largest));
  }
  return image;
}

void write_heatmap(const std::string& path, const Heatmap& map) {
  frontend::Image raw(map.width, map.height);
  for (std::size_t i = 0; i < map.values.size(); ++i) raw.pixels[i] = glm::vec3(static_cast<float>(map.values[i]));
  frontend::write_image(path, draw_heatmap(map));
  frontend::write_image(heatmap_values_path(path), raw);
}

}  // namespace grtx::experiment
