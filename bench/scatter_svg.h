// A scatter plot as an SVG text: logarithmic x axis, linear y axis, one colour a group, the front joined by a line.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace grtx::bench {

struct ScatterPoint {
  double x = 0.0;  ///< > 0
  double y = 0.0;
  unsigned group = 0;
  bool front = false;  ///< not dominated: less x or more y than every other
  std::string label;   ///< shown by a pointer's hover, and beside points of the front
};

struct ScatterText {
  std::string title, x_axis, y_axis;
  std::vector<std::string> groups;
};

inline std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
  return out;
}

/// 1, 2 or 5 times a power of ten: so many lines at most over a range.
inline double tick_step(double range, unsigned lines) {
  double step = std::pow(10.0, std::floor(std::log10(range / lines)));
  for (const double factor : {2.0, 2.5, 2.0}) {  // 2, 5, 10
    if (range / step <= lines) break;
    step *= factor;
  }
  return step;
}

inline std::string scatter_svg(const ScatterText& text, std::vector<ScatterPoint> points) {
  static const char* const kColours[] = {"#4477aa", "#66ccee", "#228833", "#ccbb44", "#ee6677", "#aa3377"};
  constexpr double kWidth = 900, kHeight = 560, kLeft = 70, kRight = 190, kTop = 40, kBottom = 60;
  double x_low = 1e300, x_high = 0.0, y_low = 1e300, y_high = -1e300;
  for (const ScatterPoint& p : points) {
    x_low = std::min(x_low, p.x);
    x_high = std::max(x_high, p.x);
    y_low = std::min(y_low, p.y);
    y_high = std::max(y_high, p.y);
  }
  x_low = std::log10(x_low) - 0.05;
  x_high = std::log10(x_high) + 0.05;
  const double y_margin = y_high > y_low ? 0.08 * (y_high - y_low) : 1.0;
  y_low -= y_margin;
  y_high += y_margin;
  const auto x_of = [&](double x) {
    return kLeft + (std::log10(x) - x_low) / (x_high - x_low) * (kWidth - kLeft - kRight);
  };
  const auto y_of = [&](double y) {
    return kHeight - kBottom - (y - y_low) / (y_high - y_low) * (kHeight - kTop - kBottom);
  };

  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" font-family=\"sans-serif\" font-size=\"12\">\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n<text x=\"{2}\" y=\"22\" font-size=\"15\">{3}</text>\n",
      kWidth, kHeight, kLeft, escaped(text.title));
  for (int decade = static_cast<int>(std::floor(x_low)); decade <= static_cast<int>(std::ceil(x_high)); ++decade) {
    for (const int digit : {1, 2, 3, 4, 5, 6, 7, 8, 9}) {
      if (x_high - x_low > 0.8 && digit != 1 && digit != 2 && digit != 5) continue;
      const double x = digit * std::pow(10.0, decade);
      if (std::log10(x) < x_low || std::log10(x) > x_high) continue;
      svg += fmt::format(
          "<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\" stroke=\"#ddd\"/>"
          "<text x=\"{0:.1f}\" y=\"{3}\" text-anchor=\"middle\">{4:g}</text>\n",
          x_of(x), kTop, kHeight - kBottom, kHeight - kBottom + 18, x);
    }
  }
  const double y_step = tick_step(y_high - y_low, 8);
  for (double tick = std::ceil(y_low / y_step); tick * y_step <= y_high; ++tick) {
    const double y = tick * y_step + 0.0;  // no -0
    svg += fmt::format(
        "<line x1=\"{1}\" x2=\"{2}\" y1=\"{0:.1f}\" y2=\"{0:.1f}\" stroke=\"#ddd\"/>"
        "<text x=\"{3}\" y=\"{4:.1f}\" text-anchor=\"end\">{5:g}</text>\n",
        y_of(y), kLeft, kWidth - kRight, kLeft - 6, y_of(y) + 4, y);
  }
  svg += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
                     kLeft + (kWidth - kLeft - kRight) / 2, kHeight - 18, escaped(text.x_axis));
  svg += fmt::format("<text transform=\"translate(18 {:.1f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                     kTop + (kHeight - kTop - kBottom) / 2, escaped(text.y_axis));

  std::sort(points.begin(), points.end(), [](const ScatterPoint& a, const ScatterPoint& b) { return a.x < b.x; });
  std::string line;
  for (const ScatterPoint& p : points) {
    if (p.front) line += fmt::format("{:.1f},{:.1f} ", x_of(p.x), y_of(p.y));
  }
  svg += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"black\" stroke-width=\"1.2\"/>\n", line);
  for (const ScatterPoint& p : points) {
    svg += fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\" fill=\"{}\" fill-opacity=\"{}\" {}><title>{}</title>"
        "</circle>\n",
        x_of(p.x), y_of(p.y), p.front ? 5 : 4, kColours[p.group % 6], p.front ? "1" : "0.55",
        p.front ? "stroke=\"black\"" : "", escaped(p.label));
  }
  for (std::size_t g = 0; g < text.groups.size(); ++g) {
    const double y = kTop + 12 + 20 * static_cast<double>(g);
    svg += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"5\" fill=\"{}\"/><text x=\"{}\" y=\"{}\">{}</text>\n",
                       kWidth - kRight + 20, y, kColours[g % 6], kWidth - kRight + 32, y + 4, escaped(text.groups[g]));
  }
  return svg + "</svg>\n";
}

}  // namespace grtx::bench
