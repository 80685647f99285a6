// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/scene/ply_reader.h"

#include <array>

#include "grtx/base/error.h"

namespace grtx::frontend {
namespace {

// Training modes that programs record in comments and that this tracer does not reproduce.
void notice_comments(const PlyHeader& header, RawRows& rows) {
  for (const std::string& comment : header.comments) {
    if (comment.find("SplatRenderMode: mip") != std::string::npos ||
        comment.find("antialiased 1") != std::string::npos) {
      rows.noticed["trained with an anti-aliasing filter (header comment)"] =
          header.elements[*header.find("vertex")].rows;
    }
  }
}

}  // namespace

std::size_t required_property(const PlyElement& element, const std::string& property, const std::string& file) {
  const auto index = element.find(property);
  if (!index) {
    const bool flat = property == "scale_2" && element.find("scale_1");
    throw Error(file, "element \"" + element.name + "\"",
                "needs the property \"" + property + "\"" + (flat ? " (a 2DGS file has none and cannot be read)" : ""));
  }
  if (element.properties[*index].list_count) {
    throw Error(file, "element \"" + element.name + "\"", "property \"" + property + "\" must not be a list");
  }
  return *index;
}

unsigned sh_degree_of(const PlyElement& element, const std::string& file) {
  std::size_t count = 0;
  for (const PlyProperty& p : element.properties) {
    if (p.name.starts_with("f_rest_")) ++count;
  }
  constexpr std::array<std::size_t, 5> kCounts{0, 9, 24, 45, 72};
  for (unsigned degree = 0; degree < kCounts.size(); ++degree) {
    if (kCounts[degree] != count) continue;
    for (std::size_t i = 0; i < count; ++i) required_property(element, "f_rest_" + std::to_string(i), file);
    return degree;
  }
  throw Error(file, "element \"" + element.name + "\"",
              "must have 0, 9, 24, 45 or 72 properties f_rest_N, not " + std::to_string(count));
}

void append_sh_columns(const PlyElement& element, unsigned degree, float* sh, std::vector<PlyColumn>& columns) {
  const std::size_t coefficients = (degree + 1) * (degree + 1);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    for (std::size_t j = 1; j < coefficients; ++j) {
      const std::string name = "f_rest_" + std::to_string(channel * (coefficients - 1) + j - 1);
      columns.push_back({*element.find(name), sh + j * 3 + channel, coefficients * 3});
    }
  }
}

RawRows read_ply(std::string_view bytes, const PlyHeader& header, const std::string& file) {
  const auto vertex = header.find("vertex");
  if (!vertex) throw Error(file, "header", "needs an element \"vertex\"");
  const PlyElement& element = header.elements[*vertex];
  const unsigned degree = sh_degree_of(element, file);
  const auto index = [&](const std::string& name) { return required_property(element, name, file); };
  // All names are looked up before memory is taken.
  const std::array<std::size_t, 3> position{index("x"), index("y"), index("z")};
  const std::array<std::size_t, 3> dc{index("f_dc_0"), index("f_dc_1"), index("f_dc_2")};
  const std::size_t opacity = index("opacity");
  const std::array<std::size_t, 3> scale{index("scale_0"), index("scale_1"), index("scale_2")};
  const std::array<std::size_t, 4> rotation{index("rot_0"), index("rot_1"), index("rot_2"), index("rot_3")};
  const PlyElements elements(bytes, header, file);

  RawRows rows;
  rows.sh_degree = degree;
  if (elements.trailing_bytes() > 0) rows.noticed["bytes behind the last element"] = elements.trailing_bytes();
  if (element.rows == 0) return rows;
  notice_comments(header, rows);
  const std::size_t n = static_cast<std::size_t>(element.rows);
  const std::size_t sh_stride = std::size_t{3} * (degree + 1) * (degree + 1);
  rows.resize(n);
  std::vector<PlyColumn> columns{{position[0], rows.x.data(), 1},
                                 {position[1], rows.y.data(), 1},
                                 {position[2], rows.z.data(), 1},
                                 {opacity, rows.opacity_logit.data(), 1}};
  for (std::size_t i = 0; i < 3; ++i) columns.push_back({dc[i], rows.sh.data() + i, sh_stride});
  for (std::size_t i = 0; i < 3; ++i) columns.push_back({scale[i], rows.log_scale.data() + i, 3});
  for (std::size_t i = 0; i < 4; ++i) columns.push_back({rotation[i], rows.rotation.data() + i, 4});
  append_sh_columns(element, degree, rows.sh.data(), columns);
  elements.read(*vertex, columns);
  return rows;
}

}  // namespace grtx::frontend
