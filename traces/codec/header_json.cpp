// SPDX-License-Identifier: Apache-2.0
#include "grtx/traces/codec/header_json.h"

#include <concepts>
#include <limits>
#include <nlohmann/json.hpp>

#include "grtx/base/error.h"
#include "grtx/base/json.h"
#include "grtx/traces/byte_stream.h"
#include "grtx/traces/checkpoint_bins.h"
#include "grtx/traces/count_totals.h"
#include "grtx/traces/event.h"

namespace grtx::traces {
namespace {

using Json = nlohmann::json;

// The single list of fields, used for writing, reading and counting known keys.
template <typename HeaderType, typename Visit>
void for_each_header_field(HeaderType& h, std::uint32_t version, Visit&& visit) {
  visit("accel", h.accel);
  visit("tracing", h.tracing);
  visit("k", h.k);
  visit("checkpoint", h.checkpoint);
  visit("checkpoint_order", h.checkpoint_order);
  visit("child_order", h.child_order);
  if (version >= 5) visit("pop_test", h.pop_test);
  visit("width", h.width);
  visit("height", h.height);
  visit("warp_size", h.warp_size);
  visit("warp_mapping", h.warp_mapping);
  visit("groups", h.groups);
  visit("layout", h.layout);
  visit("bvh_width", h.bvh_width);
  visit("node_image_bytes", h.node_image_bytes);
  visit("root", h.root);
  visit("two_level", h.two_level);
  visit("blas_base", h.blas_base);
  visit("blas_root", h.blas_root);
  visit("blas_bytes", h.blas_bytes);
  visit("blas_root_is_leaf", h.blas_root_is_leaf);
  if (version >= 6) {
    visit("object_roots", h.object_roots);
    visit("scene_leaves", h.scene_leaves);
  }
  if (version >= 7) visit("frame_groups", h.frame_groups);
  if (version >= 9) visit("checkpoint_bins", h.checkpoint_bins);
  if (version >= 11) {
    visit("any_hit", h.any_hit);
    visit("ert_check", h.ert_check);
  }
  if (version >= 12) visit("ahead", h.ahead);
  if (version >= 13) visit("wide_leaves", h.wide_leaves);
  if (version >= 14) visit("opacity_bound", h.opacity_bound);
  if (version >= 16) visit("colour", h.colour);
  visit("gaussians", h.gaussians);
  visit("sh_degree", h.sh_degree);
  visit("gaussian_record_bytes", h.gaussian_record_bytes);
  visit("sh_record_bytes", h.sh_record_bytes);
  visit("checkpoint_capacity", h.checkpoint_capacity);
  visit("inputs", h.inputs);
}

template <typename TotalsType, typename Visit>
void for_each_total(TotalsType& t, Visit&& visit) {
  for (const TotalField& field : kTotalFields) visit(field.name, t.*field.value);
}

void take(const Json& value, const std::string& key, bool& out) {
  if (!value.is_boolean()) throw Malformed("key '" + key + "' must be true or false");
  out = value.get<bool>();
}
void take(const Json& value, const std::string& key, std::string& out) {
  if (!value.is_string()) throw Malformed("key '" + key + "' must be a string");
  out = value.get<std::string>();
}
template <NamedEnum Enum>
void take(const Json& value, const std::string& key, Enum& out) {
  std::string name;
  take(value, key, name);
  const auto known = from_name<Enum>(name);
  if (!known) throw Malformed("key '" + key + "' " + unknown_name(name, names_of<Enum>()));
  out = *known;
}
template <std::unsigned_integral T>
void take(const Json& value, const std::string& key, T& out) {
  if (!value.is_number_unsigned()) throw Malformed("key '" + key + "' must be a whole number >= 0");
  const auto number = value.get<std::uint64_t>();
  if (number > std::numeric_limits<T>::max()) throw Malformed("key '" + key + "' is too large");
  out = static_cast<T>(number);
}
void take(const Json& value, const std::string& key, SceneLeaf& out) {
  if (!value.is_array() || value.size() != 2)
    throw Malformed("key '" + key + "' must hold pairs of address and object");
  take(value[0], key, out.address);
  take(value[1], key, out.object);
}
template <typename T>
void take(const Json& value, const std::string& key, std::vector<T>& out) {
  if (!value.is_array()) throw Malformed("key '" + key + "' must be a list");
  for (const Json& entry : value) take(entry, key, out.emplace_back());
}
void take(const Json& value, const std::string& key, std::map<std::string, std::string>& out) {
  if (!value.is_object()) throw Malformed("key '" + key + "' must be an object");
  for (const auto& [name, text] : value.items()) {
    std::string place = key;
    take(text, place.append(".").append(name), out[name]);
  }
}

Json parse_object(std::string_view text) {
  Json json;
  try {
    json = parse_json<Json>(text, "");
  } catch (const Error& error) {
    throw Malformed(error.rule());
  }
  if (!json.is_object()) throw Malformed("is not a JSON object");
  return json;
}

Json to_json_value(const std::vector<SceneLeaf>& leaves) {
  Json list = Json::array();
  for (const SceneLeaf& leaf : leaves) list.push_back({leaf.address, leaf.object});
  return list;
}
template <typename T>
Json to_json_value(const T& field) {
  if constexpr (NamedEnum<T>) {
    return name_of(field);
  } else {
    return field;
  }
}

// Reads and removes every field that `for_each` lists from `json`; a key left over is unknown.
template <typename ForEach>
void take_all(Json json, ForEach&& for_each) {
  for_each([&](const char* key, auto& field) {
    const auto found = json.find(key);
    if (found == json.end()) throw Malformed("key '" + std::string(key) + "' is missing");
    take(*found, key, field);
    json.erase(found);
  });
  if (!json.empty()) throw Malformed("key '" + json.begin().key() + "' is unknown");
}

}  // namespace

std::string header_to_json(const Header& header) {
  Json json = Json::object();
  for_each_header_field(header, format_version(header),
                        [&](const char* key, const auto& field) { json[key] = to_json_value(field); });
  // The default layout is not written: older traces, made when it was the only one, have no such key.
  if (header.layout == NodeLayout::vulkan_sim) json.erase("layout");
  return json_text(json);
}

Header header_from_json(std::string_view text, std::uint32_t version) {
  Header header;
  Json json = parse_object(text);
  if (!json.contains("layout")) json["layout"] = name_of(NodeLayout::vulkan_sim);
  take_all(std::move(json), [&](auto&& visit) { for_each_header_field(header, version, visit); });
  if (format_version(header) > version) {
    const char* const key = header.tracing == Tracing::list ? "tracing"
                            : has_box_leaves(header.accel)  ? "accel"
                                                            : "child_order";
    throw Malformed("key '" + std::string(key) + "' holds a value that version " + std::to_string(version) +
                    " does not have");
  }
  if (const std::string fault = header_fault(header); !fault.empty()) throw Malformed(fault);
  return header;
}

namespace {

/// The rule that the lists of a three-level structure break; "" if none.
std::string scene_fault(const Header& h) {
  if (!h.three_level()) return h.scene_leaves.empty() ? "" : "scene_leaves need object_roots";
  if (!h.two_level) return "object_roots need two_level";
  const NodeSizes sizes = h.node_sizes();
  std::uint64_t least = h.root + sizes.header_bytes();
  for (const std::uint64_t root : h.object_roots) {
    if (root % sizes.unit() != 0) return "object_roots must be multiples of " + std::to_string(sizes.unit());
    if (root <= least || root >= h.blas_base) return "object_roots must ascend between root and blas_base";
    least = root;
  }
  if (h.scene_leaves.empty()) return "scene_leaves must be one or more";
  std::uint64_t end = h.root;
  for (const SceneLeaf& leaf : h.scene_leaves) {
    if (leaf.address % sizes.unit() != 0) return "scene_leaves must be multiples of " + std::to_string(sizes.unit());
    if (leaf.address < end || leaf.address + sizes.bytes(NodeKind::instance) > h.objects_base()) {
      return "scene_leaves must ascend between root and the first of object_roots";
    }
    if (leaf.object >= h.object_roots.size()) return "scene_leaves must name one of object_roots";
    end = leaf.address + sizes.bytes(NodeKind::instance);
  }
  return "";
}

// Upper limits of header fields. The hardware model addresses 2^37 B; per-ray buffers get what the scene leaves.
constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 28;
constexpr unsigned kMostShDegree = 4;
constexpr std::uint64_t kMostSceneBytes = std::uint64_t{1} << 36;
constexpr std::uint64_t kMostCheckpoints = std::uint64_t{1} << 24;

std::string mode_fault(const Header& h) {
  if (h.k < 1 || h.k > kMaxShifts) return "k must be 1.." + std::to_string(kMaxShifts);
  if (h.tracing == Tracing::closest && h.k != 1) return "k must be 1 when tracing is closest";
  if (h.tracing != Tracing::multi && h.checkpoint) return "checkpoint must be false unless tracing is multi";
  if (h.any_hit == AnyHit::delayed && (h.tracing != Tracing::multi || h.checkpoint)) {
    return "any_hit may be delayed only when tracing is multi and checkpoint is false";
  }
  if (h.ert_check == ErtCheck::round && h.tracing == Tracing::list) {
    return "ert_check must be hit when tracing is list, whose batches are tested one by one";
  }
  if (h.ahead < 1 || h.ahead > kMostAhead) return "ahead must be 1.." + std::to_string(kMostAhead);
  if (h.ahead > 1 && (h.tracing != Tracing::multi || h.any_hit == AnyHit::delayed || h.checkpoint || h.two_level)) {
    return "ahead must be 1 unless tracing is multi, any_hit immediate, and checkpoint and two_level are false";
  }
  if (h.opacity_bound == OpacityBound::on &&
      (h.tracing != Tracing::multi || h.any_hit == AnyHit::delayed || h.ert_check == ErtCheck::round)) {
    return "opacity_bound must be off unless tracing is multi, any_hit immediate and ert_check hit";
  }
  if (h.colour == ColourPer::frame && h.three_level()) return "colour must be hit when there are object_roots";
  return "";
}

std::string structure_fault(const Header& h) {
  if (h.warp_size < 1 || h.warp_size > 64) return "warp_size must be 1..64";
  if (h.bvh_width < 2 || h.bvh_width > kMaxWidth) return "bvh_width must be 2..8";
  if (h.layout == NodeLayout::quantised && h.bvh_width > kQuantisedWidth)
    return "bvh_width must be at most 6 in layout quantised";
  if (h.wide_leaves != 0 && (h.layout != NodeLayout::quantised || h.wide_leaves > h.gaussians)) {
    return "wide_leaves must be at most gaussians, and 0 unless layout is quantised";
  }
  if (h.groups > std::numeric_limits<std::uint32_t>::max()) return "groups must be below 2^32";
  if (h.gaussians > (1ULL << 31)) return "gaussians must be at most 2^31";
  const std::uint64_t unit = h.node_sizes().unit();
  if (h.node_image_bytes > (kNodeUnit << 32)) return "node_image_bytes must be at most 256 GiB";
  for (const std::uint64_t address : {h.root, h.blas_base, h.blas_root}) {
    if (address % unit != 0) return "root, blas_base and blas_root must be multiples of " + std::to_string(unit);
    if (address != 0 && address >= h.node_image_bytes)
      return "root, blas_base and blas_root must lie in the node image";
  }
  if (h.two_level && (h.blas_base == 0 || h.blas_root < h.blas_base)) {
    return "blas_root must lie behind blas_base, which must not be 0, when two_level";
  }
  return "";
}

std::string size_fault(const Header& h) {
  if (h.width > kMostPixels || h.height > kMostPixels || std::uint64_t{h.width} * h.height > kMostPixels) {
    return "width and height must be at most 2^28 pixels";
  }
  if (h.sh_degree > kMostShDegree || h.sh_record_bytes != sh_record_bytes(h.layout, h.sh_degree)) {
    return "sh_record_bytes must be what layout and sh_degree, which is at most 4, give";
  }
  if (h.gaussian_record_bytes % 16 != 0 || h.gaussian_record_bytes > 256) {
    return "gaussian_record_bytes must be a multiple of 16 and at most 256";
  }
  if (h.node_image_bytes + h.gaussians * (h.gaussian_record_bytes + h.sh_record_bytes) > kMostSceneBytes) {
    return "node image and records must take at most 64 GiB";
  }
  return "";
}

std::string checkpoint_fault(const Header& h) {
  if (h.checkpoint_bins != 0 && (!h.checkpoint || h.checkpoint_capacity == 0)) {
    return "checkpoint_bins need checkpoint and a checkpoint_capacity of 1 or more";
  }
  if (h.checkpoint_bins > kMaxCheckpointBins || h.checkpoint_bins == 1) {
    return "checkpoint_bins must be 0 or 2.." + std::to_string(kMaxCheckpointBins);
  }
  if (h.checkpoint_bins != 0 && h.checkpoint_order != CheckpointOrder::fifo) {
    return "checkpoint_bins are read in an order of their own: checkpoint_order must be fifo";
  }
  if (h.checkpoint_capacity > kMostCheckpoints) return "checkpoint_capacity must be at most 2^24";
  if (h.checkpoint && h.checkpoint_capacity == 0) return "checkpoint_capacity must be above 0 when checkpoint is true";
  if (!h.checkpoint && h.checkpoint_capacity != 0) return "checkpoint_capacity must be 0 when checkpoint is false";
  return "";
}

std::string frame_fault(const Header& h) {
  std::uint64_t left = h.groups;
  for (const std::uint64_t groups : h.frame_groups) {
    if (groups == 0 || groups > left) return "frame_groups must be at least 1 each and add up to groups";
    left -= groups;
  }
  if (!h.frame_groups.empty() && left != 0) return "frame_groups must be at least 1 each and add up to groups";
  return "";
}

}  // namespace

std::string header_fault(const Header& h) {
  for (const auto& fault_of : {mode_fault, structure_fault, size_fault, checkpoint_fault, frame_fault, scene_fault}) {
    if (std::string fault = fault_of(h); !fault.empty()) return fault;
  }
  return "";
}

std::string totals_to_json(const Totals& totals) {
  Json json = Json::object();
  for_each_total(totals, [&](const char* key, const auto& field) { json[key] = field; });
  return json_text(json);
}

Totals totals_from_json(std::string_view text) {
  Totals totals;
  take_all(parse_object(text), [&](auto&& visit) { for_each_total(totals, visit); });
  return totals;
}

}  // namespace grtx::traces
