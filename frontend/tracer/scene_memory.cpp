// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/tracer/scene_memory.h"

#include <array>
#include <cstring>
#include <glm/geometric.hpp>
#include <string_view>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/base/fp16.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/gaussian/prepared_gaussians.h"
#include "grtx/traces/memory_contents.h"
#include "grtx/traces/reader.h"

namespace grtx::frontend {
namespace {

template <typename T>
std::string_view bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// Mean, scales, rotation as x y z w, opacity, 0.
using Record = std::array<float, 12>;

std::vector<Record> records_of(const Scene& scene) {
  std::vector<Record> records(scene.size());
  for (std::size_t g = 0; g < records.size(); ++g) {
    const glm::vec3 &m = scene.mean[g], &s = scene.scale[g];
    const glm::quat& r = scene.rotation[g];
    records[g] = {m.x, m.y, m.z, s.x, s.y, s.z, r.x, r.y, r.z, r.w, scene.opacity[g], 0.0f};
  }
  return records;
}

/// Rows of the map from the scene to the unit sphere: p = row . (x, 1).
using Shape = std::array<float, 12>;

/// By unit of the node image; 0 where no leaf begins.
std::vector<Shape> shapes_of(const ViewTracer& view) {
  const NodeImage& image = view.accel().image();
  const std::uint64_t unit = image.sizes().unit();
  std::vector<Shape> shapes(image.size() / unit);
  std::vector<std::uint64_t> nodes = {view.accel().root()};
  while (!nodes.empty()) {
    const DecodedInternal node = image.decode_internal(nodes.back());
    nodes.pop_back();
    std::uint64_t child = node.child_base;
    for (unsigned i = 0; i < node.child_count; child += image.sizes().bytes(node.kinds[i]), ++i) {
      if (node.kinds[i] == NodeKind::internal) {
        nodes.push_back(child);
        continue;
      }
      const GaussianRecord& g = view.gaussians().record(image.procedural_primitive(child));
      Shape& shape = shapes[child / unit];
      for (std::size_t row = 0; row < 3; ++row) {
        const glm::vec3& a = g.to_unit[row];
        const float values[] = {a.x, a.y, a.z, -glm::dot(a, g.mean)};
        std::memcpy(&shape[4 * row], values, sizeof values);
      }
    }
  }
  return shapes;
}

/// Layout quantised: fp16 in whole words.
std::vector<std::uint16_t> halves_of(const Scene& scene, std::uint64_t record_bytes) {
  const std::size_t values = std::size_t{3} * scene.sh_coefficients();
  std::vector<std::uint16_t> halves(scene.size() * record_bytes / 2);
  for (std::size_t g = 0; g < scene.size(); ++g) {
    for (std::size_t i = 0; i < values; ++i) halves[g * record_bytes / 2 + i] = fp16_bits(scene.sh[g * values + i]);
  }
  return halves;
}

std::vector<std::array<float, 4>> pixels_of(const Image& image) {
  std::vector<std::array<float, 4>> pixels;
  pixels.reserve(image.pixels.size());
  for (const glm::vec3& colour : image.pixels) pixels.push_back({colour.r, colour.g, colour.b, 0.0f});
  return pixels;
}

}  // namespace

void write_scene_memory(const std::string& path, const std::string& trace_file, const ViewTracer& view,
                        const TracedView& traced) {
  if (!traced.further.empty()) throw Error(path, "", "memory contents are of one frame, not of a sequence");
  const traces::Reader reader(trace_file);
  const traces::Header& header = reader.header();
  const Scene& scene = view.scene();
  const NodeImage& image = view.accel().image();
  const std::vector<Record> records = records_of(scene);
  const bool boxes = !header.two_level && traces::has_box_leaves(header.accel);
  const std::vector<Shape> shapes = boxes ? shapes_of(view) : std::vector<Shape>{};
  const bool half = header.layout == traces::NodeLayout::quantised;
  const std::vector<std::uint16_t> halves =
      half ? halves_of(scene, header.sh_record_bytes) : std::vector<std::uint16_t>{};
  const std::vector<std::array<float, 4>> pixels = pixels_of(traced.result.image);
  std::vector<traces::MemoryRegion> regions = {
      {traces::kNodeImageRegion, {reinterpret_cast<const char*>(image.data()), image.size()}},
      {traces::kGaussianRegion, bytes_of(records)}};
  if (boxes) regions.push_back({traces::kShapeRegion, bytes_of(shapes)});
  regions.push_back({traces::kShRegion, half ? bytes_of(halves) : bytes_of(scene.sh)});
  regions.push_back({traces::kPixelRegion, bytes_of(pixels)});
  traces::write_memory_contents(path, reader.content_hash(), regions);
}

}  // namespace grtx::frontend
