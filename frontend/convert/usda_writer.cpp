// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/frontend/convert/scene_writer.h"
#include "grtx/frontend/convert/writable_rows.h"

namespace grtx::frontend {
namespace {

/// Linear scale and opacity as double: with all their digits they lead back to the float of their logarithm and logit.
double scale_of(float log_scale) { return std::exp(static_cast<double>(log_scale)); }
double opacity_of(float logit) { return 1.0 / (1.0 + std::exp(-static_cast<double>(logit))); }

/// Writes lists of the rows `kept`, piece by piece.
class ListWriter {
 public:
  ListWriter(AtomicFile& file, const std::vector<std::size_t>& kept) : file_(file), kept_(kept) {}

  /// item: appends one row's text to a string.
  template <typename Item>
  void write(const char* declaration, const Item& item, const char* end = "]\n") {
    std::string text = fmt::format("        {} = [", declaration);
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      if (i > 0) text += ", ";
      item(kept_[i], text);
      if (text.size() > (1U << 20)) {
        file_.write(text);
        text.clear();
      }
    }
    file_.write(text + end);
  }

 private:
  AtomicFile& file_;
  const std::vector<std::size_t>& kept_;
};

/// Numbers in brackets. A float has the fewest digits that read as the same float, at most 9.
template <typename... Numbers>
void tuple(std::string& text, const char* format, Numbers... numbers) {
  fmt::format_to(std::back_inserter(text), fmt::runtime(format), numbers...);
}

/// Box of all Gaussians, three scales wide.
std::string extent_of(const RawRows& rows, const std::vector<std::size_t>& kept) {
  std::array<double, 3> low{}, high{};
  low.fill(std::numeric_limits<double>::infinity());
  high.fill(-std::numeric_limits<double>::infinity());
  for (const std::size_t i : kept) {
    const std::array<double, 3> centre{rows.x[i], rows.y[i], rows.z[i]};
    const double reach = 3.0 * scale_of(*std::max_element(&rows.log_scale[i * 3], &rows.log_scale[i * 3] + 3));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], centre[axis] - reach);
      high[axis] = std::max(high[axis], centre[axis] + reach);
    }
  }
  const auto number = [](double value) { return static_cast<float>(value); };
  return fmt::format("        float3[] extent = [({}, {}, {}), ({}, {}, {})]\n", number(low[0]), number(low[1]),
                     number(low[2]), number(high[0]), number(high[1]), number(high[2]));
}

}  // namespace

std::uint64_t write_usda(const RawRows& rows, const std::string& path) {
  const std::size_t harmonics = harmonics_of(rows, path);
  std::vector<std::size_t> kept = writable_rows(rows, harmonics);
  std::erase_if(kept, [&](std::size_t i) {  // linear scales have less range than their logarithms
    return std::any_of(&rows.log_scale[i * 3], &rows.log_scale[i * 3] + 3,
                       [](float value) { return std::isinf(static_cast<float>(scale_of(value))); });
  });
  AtomicFile file(path);
  file.write(
      "#usda 1.0\n(\n    defaultPrim = \"World\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n\n"
      "def Xform \"World\"\n{\n    def ParticleField3DGaussianSplat \"gaussians\"\n    {\n");
  if (!kept.empty()) file.write(extent_of(rows, kept));
  ListWriter lists(file, kept);
  lists.write("point3f[] positions", [&](std::size_t i, std::string& text) {
    tuple(text, "({}, {}, {})", static_cast<float>(rows.x[i]), static_cast<float>(rows.y[i]),
          static_cast<float>(rows.z[i]));
  });
  lists.write("float3[] scales", [&](std::size_t i, std::string& text) {
    const float* s = &rows.log_scale[i * 3];
    tuple(text, "({}, {}, {})", scale_of(s[0]), scale_of(s[1]), scale_of(s[2]));
  });
  lists.write("quatf[] orientations", [&](std::size_t i, std::string& text) {
    const float* q = &rows.rotation[i * 4];
    tuple(text, "({}, {}, {}, {})", q[0], q[1], q[2], q[3]);
  });
  lists.write("float[] opacities",
              [&](std::size_t i, std::string& text) { tuple(text, "{}", opacity_of(rows.opacity_logit[i])); });
  file.write(fmt::format("        uniform int radiance:sphericalHarmonicsDegree = {}\n", rows.sh_degree));
  const std::string end = fmt::format(
      "] (\n            elementSize = {}\n            interpolation = \"vertex\"\n        )\n", harmonics / 3);
  lists.write(
      "float3[] radiance:sphericalHarmonicsCoefficients",
      [&](std::size_t i, std::string& text) {
        for (std::size_t k = 0; k < harmonics; k += 3) {
          const float* sh = &rows.sh[i * harmonics + k];
          tuple(text, k == 0 ? "({}, {}, {})" : ", ({}, {}, {})", sh[0], sh[1], sh[2]);
        }
      },
      end.c_str());
  file.write("    }\n}\n");
  file.commit();
  return rows.x.size() - kept.size();
}

}  // namespace grtx::frontend
