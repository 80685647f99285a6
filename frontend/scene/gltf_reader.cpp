// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/scene/readers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/base/json.h"
#include "grtx/frontend/scene/file_beside.h"
#include "grtx/frontend/scene/raw_encoding.h"
#include "grtx/frontend/scene/uri.h"

namespace grtx::frontend {
namespace {

using nlohmann::json;

constexpr std::uint32_t kJsonChunk = 0x4e4f534a;  // "JSON"
constexpr std::uint32_t kBinChunk = 0x004e4942;   // "BIN"
constexpr const char* kExtension = "KHR_gaussian_splatting";
constexpr int kMostDepth = 64;       // deepest nesting of nodes
constexpr unsigned kMostDegree = 3;  // of SH in the extension

// Signs of the SH coefficients from k1 on under half a turn about z: those of odd order m change.
constexpr std::array<float, 15> kShSign{-1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1};

enum Component : unsigned { i8 = 5120, u8 = 5121, i16 = 5122, u16 = 5123, f32 = 5126 };

/// Contents of a .glb's chunks or of a .gltf's text.
struct Container {
  json document;
  std::string_view binary;
};

std::string at(std::size_t byte) { return "byte " + std::to_string(byte); }

Container read_container(std::string_view bytes, const std::string& file) {
  Container container;
  if (!is_glb(bytes)) {
    container.document = parse_json<json>(bytes, file);
    if (!container.document.is_object()) throw Error(file, "", "must be a JSON object");
    return container;
  }
  if (bytes.size() < 20) throw Error(file, at(bytes.size()), "ends inside the header");
  if (load<std::uint32_t>(bytes, 4) != 2) throw Error(file, at(4), "must be version 2 of glTF");
  if (load<std::uint32_t>(bytes, 8) != bytes.size())
    throw Error(file, at(8), "must be the file's size, " + std::to_string(bytes.size()));
  std::size_t begin = 12;
  bool first = true;
  while (begin < bytes.size()) {
    if (bytes.size() - begin < 8) throw Error(file, at(begin), "ends inside the header of a chunk");
    const std::size_t size = load<std::uint32_t>(bytes, begin);
    const auto type = load<std::uint32_t>(bytes, begin + 4);
    begin += 8;
    if (size > bytes.size() - begin) throw Error(file, at(begin), "the chunk goes beyond the file's end");
    const std::string_view chunk = bytes.substr(begin, size);
    if (first && type != kJsonChunk) throw Error(file, at(begin), "the first chunk must be JSON");
    if (first) container.document = parse_json<json>(chunk, file, "JSON chunk");
    if (!first && type == kBinChunk && container.binary.empty()) container.binary = chunk;
    first = false;
    begin += size;
  }
  if (!container.document.is_object()) throw Error(file, "JSON chunk", "must be a JSON object");
  return container;
}

class Gltf {
 public:
  Gltf(std::string_view bytes, std::string file, FilesRead& files) : file_(std::move(file)), files_(files) {
    Container container = read_container(bytes, file_);
    document_ = std::move(container.document);
    binary_ = container.binary;
  }

  /// Bytes of the buffers in other files, in the order of their first use.
  std::string take_beside() { return std::move(beside_); }

  /// Nodes must be trees: a hundred nodes that share children could have practically endless paths.
  bool first_visit(const json& node) { return visited_.insert(node.get<std::size_t>()).second; }

  const json& document() const { return document_; }
  const std::string& file() const { return file_; }

  /// Entry `index` of the document's list `name`.
  const json& entry(const char* name, const json& index) const {
    const std::string place = std::string(name) + "[" + json_text(index).substr(0, 20) + "]";
    if (!document_.contains(name) || !document_.at(name).is_array() || !index.is_number_unsigned() ||
        index.get<std::uint64_t>() >= document_.at(name).size() ||
        !document_.at(name).at(index.get<std::size_t>()).is_object()) {
      throw Error(file_, place, "does not exist");
    }
    return document_.at(name).at(index.get<std::size_t>());
  }

  std::size_t whole(const json& object, const char* name, std::size_t fallback, const std::string& place) const {
    if (!object.contains(name)) return fallback;
    const json& value = object.at(name);
    if (!value.is_number_unsigned() || value.get<std::uint64_t>() > std::numeric_limits<std::uint32_t>::max()) {
      throw Error(file_, place + "." + name, "must be a whole number below 2^32");
    }
    return value.get<std::size_t>();
  }

  /// Values of an attribute's accessor, `width` per Gaussian; the first attribute's count applies to all others.
  std::vector<float> attribute(const json& attributes, const std::string& name, std::size_t width, std::size_t& count) {
    if (!attributes.contains(name)) throw Error(file_, "attributes." + name, "is missing");
    const json& accessor = entry("accessors", attributes.at(name));
    const char* type = width == 1 ? "SCALAR" : width == 3 ? "VEC3" : "VEC4";
    if (accessor.value("type", json()) != type) throw Error(file_, name, std::string("must be of type ") + type);
    if (accessor.contains("sparse")) throw Error(file_, name, "sparse accessors are not supported");
    if (!accessor.contains("bufferView"))
      throw Error(file_, name, "has no bufferView: compressed splats are not supported");
    const std::size_t own = whole(accessor, "count", 0, name);
    if (count == std::numeric_limits<std::size_t>::max()) count = own;
    if (own != count) throw Error(file_, name, "must have " + std::to_string(count) + " entries, as POSITION");
    const unsigned component = static_cast<unsigned>(whole(accessor, "componentType", 0, name));
    const std::size_t bytes = component == f32                       ? 4
                              : component == i16 || component == u16 ? 2
                              : component == i8 || component == u8   ? 1
                                                                     : 0;
    if (bytes == 0) throw Error(file_, name, "must be of float, byte or short components");
    const bool normalised = accessor.value("normalized", json()) == true;

    const json& view = entry("bufferViews", accessor.at("bufferView"));
    const std::string_view buffer = buffer_of(whole(view, "buffer", 0, name));
    const std::size_t view_begin = whole(view, "byteOffset", 0, name), view_size = whole(view, "byteLength", 0, name);
    if (view_begin > buffer.size() || view_size > buffer.size() - view_begin) {
      throw Error(file_, name, "its bufferView goes beyond its buffer");
    }
    const std::size_t stride = whole(view, "byteStride", bytes * width, name);
    const std::size_t begin = whole(accessor, "byteOffset", 0, name);
    if (stride < bytes * width) throw Error(file_, name, "its byteStride is smaller than an entry");
    if (count > 0 && (begin > view_size || bytes * width > view_size - begin ||
                      (view_size - begin - bytes * width) / stride < count - 1)) {
      throw Error(file_, name, "goes beyond its bufferView");
    }
    std::vector<float> values;
    values.reserve(count * width);
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t c = 0; c < width; ++c)
        values.push_back(number(buffer, view_begin + begin + i * stride + c * bytes, component, normalised));
    }
    return values;
  }

 private:
  /// A buffer's bytes: the binary chunk, a data URI, or a file beside this one.
  std::string_view buffer_of(std::size_t index) {
    const json& buffer = entry("buffers", index);
    const std::string place = "buffers[" + std::to_string(index) + "]";
    if (!buffer.contains("uri")) {
      if (index != 0 || binary_.empty()) throw Error(file_, place, "has no uri, and no binary chunk holds it");
      return binary_;
    }
    if (const auto found = loaded_.find(index); found != loaded_.end()) return found->second;
    if (!buffer.at("uri").is_string()) throw Error(file_, place + ".uri", "must be a text");
    const std::string uri = buffer.at("uri").get<std::string>();
    std::string bytes;
    if (uri.starts_with("data:")) {
      const std::size_t comma = uri.find(";base64,");
      const std::optional<std::string> decoded =
          comma == std::string::npos ? std::nullopt : decode_base64(std::string_view(uri).substr(comma + 8));
      if (!decoded) throw Error(file_, place + ".uri", "must be data in base64");
      bytes = *decoded;
    } else {
      bytes = read_beside(file_, percent_decoded(uri), files_);
      beside_ += bytes;
    }
    return loaded_.emplace(index, std::move(bytes)).first->second;
  }

  static float number(std::string_view buffer, std::size_t at, unsigned component, bool normalised) {
    const auto integer = [&]<typename T>(T value) {
      const auto number = static_cast<float>(value);
      return normalised ? std::max(number / static_cast<float>(std::numeric_limits<T>::max()), -1.0f) : number;
    };
    switch (component) {
      case i8:
        return integer(load<std::int8_t>(buffer, at));
      case u8:
        return integer(load<std::uint8_t>(buffer, at));
      case i16:
        return integer(load<std::int16_t>(buffer, at));
      case u16:
        return integer(load<std::uint16_t>(buffer, at));
      default:
        return load<float>(buffer, at);
    }
  }

  std::string file_;
  FilesRead& files_;
  json document_;
  std::string_view binary_;
  std::map<std::size_t, std::string> loaded_;  ///< buffers with a uri
  std::string beside_;
  std::set<std::size_t> visited_;  ///< nodes
};

/// A node's transform of its points: scaled, then moved.
struct Placement {
  double scale = 1.0;
  glm::dvec3 move{0.0};
};

std::vector<double> numbers(const json& value, std::size_t count, const std::string& place, const std::string& file) {
  std::vector<double> list;
  if (value.is_array() && value.size() == count) {
    for (const json& entry : value) {
      if (entry.is_number() && std::isfinite(entry.get<double>())) list.push_back(entry.get<double>());
    }
  }
  if (list.size() != count) throw Error(file, place, "must be " + std::to_string(count) + " finite numbers");
  return list;
}

Placement placement_of(const json& node, const std::string& place, const std::string& file) {
  Placement own;
  const auto uniform = [&](double a, double b, double c) {
    if (!(a > 0.0) || std::abs(a - b) > 1e-6 * a || std::abs(a - c) > 1e-6 * a) {
      throw Error(file, place,
                  "must not rotate, mirror or stretch its splats; uniform scales and translations are read");
    }
    return a;
  };
  if (node.contains("matrix")) {  // column-major
    const std::vector<double> m = numbers(node.at("matrix"), 16, place + ".matrix", file);
    own.scale = uniform(m[0], m[5], m[10]);
    for (const std::size_t off : std::array<std::size_t, 6>{1, 2, 4, 6, 8, 9}) {
      if (std::abs(m[off]) > 1e-6 * own.scale) uniform(0.0, 0.0, 0.0);
    }
    own.move = {m[12], m[13], m[14]};
    return own;
  }
  if (node.contains("rotation")) {
    const std::vector<double> q = numbers(node.at("rotation"), 4, place + ".rotation", file);
    if (std::hypot(q[0], q[1], q[2]) > 1e-6) uniform(0.0, 0.0, 0.0);
  }
  if (node.contains("scale")) {
    const std::vector<double> s = numbers(node.at("scale"), 3, place + ".scale", file);
    own.scale = uniform(s[0], s[1], s[2]);
  }
  if (node.contains("translation")) {
    const std::vector<double> t = numbers(node.at("translation"), 3, place + ".translation", file);
    own.move = {t[0], t[1], t[2]};
  }
  return own;
}

unsigned degree_of(const json& attributes) {
  unsigned degree = 0;
  while (degree < kMostDegree &&
         attributes.contains(std::string(kExtension) + ":SH_DEGREE_" + std::to_string(degree + 1) + "_COEF_0"))
    ++degree;
  return degree;
}

/// Appends a primitive's Gaussians, turned into the axes of a .ply.
void read_primitive(Gltf& gltf, const json& primitive, const Placement& placement, bool first, RawRows& rows) {
  const std::string& file = gltf.file();
  if (primitive.value("mode", json(4U)) != 0U) throw Error(file, "primitives.mode", "must be 0: splats are points");
  if (primitive.at("extensions").at(kExtension).value("extensions", json()).is_object()) {
    throw Error(file, kExtension, "has extensions of its own: compressed splats are not supported");
  }
  const json attributes = primitive.value("attributes", json::object());
  std::size_t count = std::numeric_limits<std::size_t>::max();
  const auto own = [](const char* name) { return std::string(kExtension) + ":" + name; };
  const std::vector<float> position = gltf.attribute(attributes, "POSITION", 3, count);
  const std::vector<float> rotation = gltf.attribute(attributes, own("ROTATION"), 4, count);  // x y z w
  const std::vector<float> scale = gltf.attribute(attributes, own("SCALE"), 3, count);
  const std::vector<float> opacity = gltf.attribute(attributes, own("OPACITY"), 1, count);
  const unsigned degree = degree_of(attributes);
  if (first) rows.sh_degree = degree;
  if (degree != rows.sh_degree) throw Error(file, "attributes", "all splats must have harmonics of one degree");
  if (attributes.contains(own("SH_DEGREE_") + std::to_string(kMostDegree + 1) + "_COEF_0")) {
    throw Error(file, "attributes", "harmonics must be of degree 3 at most, as the extension has them");
  }
  rows.require_memory_for(count, file);
  std::vector<std::vector<float>> harmonics;
  for (unsigned l = 0; l <= degree; ++l) {
    for (unsigned n = 0; n <= 2 * l; ++n) {
      harmonics.push_back(
          gltf.attribute(attributes, own("SH_DEGREE_") + std::to_string(l) + "_COEF_" + std::to_string(n), 3, count));
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    const auto placed = [&](std::size_t axis) {
      return static_cast<double>(position[i * 3 + axis]) * placement.scale + placement.move[static_cast<int>(axis)];
    };
    // Half a turn about z: (x, y, z) to (-x, -y, z), and the quaternion k q = (-z, -y, x, w) of (w, x, y, z).
    rows.x.push_back(-placed(0));
    rows.y.push_back(-placed(1));
    rows.z.push_back(placed(2));
    const float* q = &rotation[i * 4];
    rows.rotation.insert(rows.rotation.end(), {-q[2], -q[1], q[0], q[3]});
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double s = static_cast<double>(scale[i * 3 + axis]) * placement.scale;
      if (s < 0.0) throw Error(file, own("SCALE"), "must not be negative");
      rows.log_scale.push_back(log_of_scale(s));
    }
    if (opacity[i] < 0.0f || opacity[i] > 1.0f) throw Error(file, own("OPACITY"), "must be 0 to 1");
    rows.opacity_logit.push_back(logit_of(static_cast<double>(opacity[i])));
    for (std::size_t k = 0; k < harmonics.size(); ++k) {
      for (std::size_t c = 0; c < 3; ++c) rows.sh.push_back(harmonics[k][i * 3 + c] * (k == 0 ? 1.0f : kShSign[k - 1]));
    }
  }
}

void read_node(Gltf& gltf, const json& index, const Placement& above, int depth, std::size_t& primitives,
               RawRows& rows) {
  const json& node = gltf.entry("nodes", index);
  const std::string place = "nodes[" + json_text(index) + "]";
  if (depth > kMostDepth) throw Error(gltf.file(), place, "nodes must be at most 64 deep");
  if (!gltf.first_visit(index)) throw Error(gltf.file(), place, "must have one parent at most");
  const json children = node.value("children", json::array());
  // Transforms of meshes without splats do not matter.
  const auto below = [&] {
    const Placement own = placement_of(node, place, gltf.file());
    return Placement{above.scale * own.scale, above.move + above.scale * own.move};
  };
  if (node.contains("mesh")) {
    const json list = gltf.entry("meshes", node.at("mesh")).value("primitives", json::array());
    for (const json& primitive : list) {
      const json extensions = primitive.is_object() ? primitive.value("extensions", json()) : json();
      if (!extensions.is_object() || !extensions.contains(kExtension) || !extensions.at(kExtension).is_object())
        continue;
      read_primitive(gltf, primitive, below(), primitives == 0, rows);
      ++primitives;
    }
  }
  if (!children.is_array()) throw Error(gltf.file(), place + ".children", "must be a list of nodes");
  for (const json& child : children) read_node(gltf, child, below(), depth + 1, primitives, rows);
}

}  // namespace

bool is_glb(std::string_view bytes) { return bytes.starts_with("glTF"); }

bool is_gltf(std::string_view bytes) {
  const std::size_t first = bytes.find_first_not_of(" \t\r\n");
  return first != std::string_view::npos && bytes[first] == '{' && bytes.find("\"asset\"") != std::string_view::npos;
}

GltfRows read_gltf(std::string_view bytes, const std::string& file, FilesRead& files) {
  Gltf gltf(bytes, file, files);
  json nodes = json::array();
  if (gltf.document().contains("scenes")) {
    const json scene = gltf.document().value("scene", json(0U));
    nodes = gltf.entry("scenes", scene).value("nodes", json::array());
  }
  if (!nodes.is_array()) throw Error(file, "scenes.nodes", "must be a list of nodes");
  GltfRows read;
  std::size_t primitives = 0;
  for (const json& node : nodes) read_node(gltf, node, Placement{}, 0, primitives, read.rows);
  if (primitives == 0) throw Error(file, "meshes", "no points with KHR_gaussian_splatting: it holds no Gaussians");
  read.beside = gltf.take_beside();
  return read;
}

}  // namespace grtx::frontend
