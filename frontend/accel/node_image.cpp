// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/accel/node_image.h"

#include <algorithm>
#include <cassert>

namespace grtx::frontend {
namespace {

template <typename T>
void put(std::uint8_t* to, T value) {
  std::memcpy(to, &value, sizeof value);
}

// Eight codes, multiples of 2, in 7 bytes.
void put_packed(std::uint8_t* to, const std::uint8_t (&codes)[traces::kMaxWidth]) {
  std::uint64_t packed = 0;
  for (unsigned i = 0; i < traces::kMaxWidth; ++i) packed |= std::uint64_t{codes[i]} >> 1 << (kPackedBits * i);
  std::memcpy(to, &packed, kPackedBits);
}

// All leaves of one level of a structure are of one kind, so one bit tells which children are leaves.
void write_packed_children(std::uint8_t* node, const ChildRecord* children, unsigned count) {
  node[kPackedUsed] = static_cast<std::uint8_t>((1u << count) - 1);
  for (unsigned i = 0; i < count; ++i) {
    if (children[i].kind == NodeKind::internal) continue;
    const auto kind = static_cast<std::uint8_t>(children[i].kind);
    assert(node[kPackedLeafKind] == 0 || node[kPackedLeafKind] == kind);
    node[kPackedLeafKind] = kind;
    node[kPackedLeaves] = static_cast<std::uint8_t>(node[kPackedLeaves] | 1u << i);
  }
}

}  // namespace

std::uint64_t NodeImage::allocate(std::uint64_t count) {
  assert(count % unit_ == 0 && used_ + count <= size());
  const std::uint64_t address = used_;
  used_ += count;
  return address;
}

void NodeImage::write_header(std::uint64_t address, std::uint64_t root, const Box& bounds) {
  std::uint8_t header[traces::kCompactUnit] = {};
  put(header, root);
  put(header + 8, bounds.lower);
  put(header + 20, bounds.upper);
  std::memcpy(at(address), header, sizes_.header_bytes());
}

void NodeImage::write_internal(std::uint64_t address, std::uint64_t child_base, const ChildRecord* children,
                               unsigned count) {
  assert(count <= width());
  // Whole lines, zeros included: the bytes may have held another node.
  std::uint8_t node[2 * sizeof(Line)] = {};
  put(node + 12, static_cast<std::int32_t>((child_base - address) / unit_));
  if (layout_.packed) {
    write_packed_children(node, children, count);
  } else {
    node[16] = static_cast<std::uint8_t>(NodeKind::internal);
    node[21] = 0xFF;
    for (unsigned i = 0; i < count; ++i) {
      const std::uint64_t units = sizes_.units(children[i].kind);
      node[layout_.child_info + i] =
          static_cast<std::uint8_t>(units | (static_cast<std::uint64_t>(children[i].kind) << 2));
    }
  }
  BoxCodes codes{{}, {-128, -128, -128}, {}, {}};
  for (auto& axis : codes.lower) std::fill_n(axis, traces::kMaxWidth, std::uint8_t{0x80});  // of missing children
  if (count > 0) encode_boxes(children, count, box_bits_, codes);
  for (unsigned axis = 0; axis < 3; ++axis) {
    put(node + 4 * axis, codes.origin[axis]);
    put(node + 18 + axis, codes.exponent[axis]);
    if (layout_.packed) {
      put_packed(node + layout_.bounds + 2 * axis * kPackedBits, codes.lower[axis]);
      put_packed(node + layout_.bounds + (2 * axis + 1) * kPackedBits, codes.upper[axis]);
      continue;
    }
    std::uint8_t* const lower = node + layout_.bounds + 2 * axis * layout_.slots;
    std::copy_n(codes.lower[axis], layout_.slots, lower);
    std::copy_n(codes.upper[axis], layout_.slots, lower + layout_.slots);
  }
  std::memcpy(at(address), node, sizes_.bytes(NodeKind::internal));
}

void NodeImage::write_triangle(std::uint64_t address, std::uint32_t primitive, const glm::vec3& a, const glm::vec3& b,
                               const glm::vec3& c) {
  const struct {
    std::uint32_t words[4];
    glm::vec3 vertices[4];
  } leaf = {{0xFF000000u, 0, primitive, 0}, {a, b, c, c}};
  static_assert(sizeof leaf == traces::kTriangleLeafBytes);
  std::memcpy(at(address), &leaf, sizeof leaf);
  leaf_index_[address / unit_] = primitive;
}

void NodeImage::write_quantised(std::uint64_t address, const QuantisedGaussian& gaussian) {
  static_assert(sizeof gaussian == traces::kQuantisedUnit);
  std::memcpy(at(address), &gaussian, sizeof gaussian);
  leaf_index_[address / unit_] = gaussian.id();
}

void NodeImage::write_mean_grid(std::uint64_t header, const MeanGrid& grid) {
  std::memcpy(at(header) + 32, &grid, sizeof grid);
}

void NodeImage::write_patch(std::uint64_t address, const PatchRecord& patch, std::uint32_t leaf) {
  const struct {
    std::array<glm::vec3, 6> vertices;
    std::uint32_t gaussian, code;
  } bytes = {patch.vertices, patch.gaussian, patch.code};
  static_assert(sizeof bytes == traces::kCompactUnit);
  std::memcpy(at(address), &bytes, sizeof bytes);
  leaf_index_[address / unit_] = leaf;
}

void NodeImage::write_procedural(std::uint64_t address, std::uint32_t primitive, const Box& box,
                                 const glm::vec3 (&world_to_object)[3], const glm::vec3& mean) {
  const struct {
    Box box;
    glm::vec3 to_object[3];
    glm::vec3 mean;
    std::uint32_t primitive, flags;
  } leaf = {box, {world_to_object[0], world_to_object[1], world_to_object[2]}, mean, primitive, 0xFF000000u};
  static_assert(sizeof leaf == traces::kCompactUnit);
  std::memcpy(at(address), &leaf, sizeof leaf);
  leaf_index_[address / unit_] = primitive;
}

void NodeImage::write_procedural(std::uint64_t address, std::uint32_t primitive, const glm::vec3* to_unit,
                                 const glm::vec3& mean) {
  struct {
    std::uint32_t words[4];
    glm::vec3 to_unit[3];
    glm::vec3 mean;
  } leaf = {{0xFF000000u, 1u << 29, 1u, primitive}, {}, mean};
  static_assert(sizeof leaf == traces::kProceduralLeafBytes);
  if (to_unit != nullptr) std::copy_n(to_unit, 3, leaf.to_unit);
  std::memcpy(at(address), &leaf, sizeof leaf);
  leaf_index_[address / unit_] = primitive;
}

void NodeImage::write_instance(std::uint64_t address, std::uint32_t instance, std::uint64_t blas_header,
                               std::uint64_t blas_root, const glm::vec3 (&world_to_object)[3],
                               const glm::vec3 (&object_to_world)[3], const glm::vec3& translation) {
  if (compact()) {
    write_compact_instance(address, instance, blas_header, blas_root, world_to_object, object_to_world, translation);
    return;
  }
  if (layout_.packed) {
    write_compressed_instance(address, instance, blas_root, world_to_object, translation);
    return;
  }
  struct {
    std::uint32_t id, flags;
    std::uint64_t root;
    glm::vec3 to_object[3];
    glm::vec3 translation;
    std::uint64_t header;
    std::uint32_t index[2];
    glm::vec3 to_world[3];
    glm::vec3 object_translation;
  } leaf;
  static_assert(sizeof leaf == traces::kInstanceLeafBytes);
  leaf.id = 0xFF000000u | (instance & 0xFFFFFFu);
  leaf.flags = 0;
  leaf.root = blas_root;
  leaf.translation = translation;
  leaf.header = blas_header;
  leaf.index[0] = leaf.index[1] = instance;
  for (int row = 0; row < 3; ++row) {
    const glm::vec3& m = world_to_object[row];
    leaf.to_object[row] = m;
    leaf.to_world[row] = object_to_world[row];
    leaf.object_translation[row] = -(m.x * translation.x + m.y * translation.y + m.z * translation.z);
  }
  std::memcpy(at(address), &leaf, sizeof leaf);
  leaf_index_[address / unit_] = instance;
}

// Traversal only reads the first unit; the second is for shaders and for a rebuild.
void NodeImage::write_compact_instance(std::uint64_t address, std::uint32_t instance, std::uint64_t blas_header,
                                       std::uint64_t blas_root, const glm::vec3 (&world_to_object)[3],
                                       const glm::vec3 (&object_to_world)[3], const glm::vec3& translation) {
  struct {
    glm::vec3 to_object[3];
    glm::vec3 translation;
    std::uint64_t root, header;
    std::uint32_t index, id_and_mask, shader_and_flags, instance_id;
    glm::vec3 to_world[3];
    glm::vec3 object_translation;
    std::uint64_t reserved[4];
  } leaf;
  static_assert(sizeof leaf == 2 * traces::kCompactUnit);
  std::memset(&leaf, 0, sizeof leaf);
  leaf.root = blas_root;
  leaf.header = blas_header;
  leaf.translation = translation;
  leaf.index = leaf.instance_id = instance;
  leaf.id_and_mask = 0xFF000000u | (instance & 0xFFFFFFu);
  for (int row = 0; row < 3; ++row) {
    const glm::vec3& m = world_to_object[row];
    leaf.to_object[row] = m;
    leaf.to_world[row] = object_to_world[row];
    leaf.object_translation[row] = -(m.x * translation.x + m.y * translation.y + m.z * translation.z);
  }
  std::memcpy(at(address), &leaf, sizeof leaf);
  leaf_index_[address / unit_] = instance;
}

// Only what traversal reads: what a shader or an update needs besides (object-to-world) is not part of the image.
void NodeImage::write_compressed_instance(std::uint64_t address, std::uint32_t instance, std::uint64_t blas_root,
                                          const glm::vec3 (&world_to_object)[3], const glm::vec3& translation) {
  const struct {
    glm::vec3 to_object[3];
    glm::vec3 translation;
    std::uint64_t root;
    std::uint32_t index, id_and_mask;
  } leaf = {{world_to_object[0], world_to_object[1], world_to_object[2]},
            translation,
            blas_root,
            instance,
            0xFF000000u | (instance & 0xFFFFFFu)};
  static_assert(sizeof leaf == traces::kCompressedBytes);
  std::memcpy(at(address), &leaf, sizeof leaf);
  leaf_index_[address / unit_] = instance;
}

DecodedInternal NodeImage::decode_internal(std::uint64_t address) const {
  DecodedInternal node;
  const std::uint8_t* bytes = data() + address;
  std::int32_t offset = 0;
  std::memcpy(&offset, bytes + 12, 4);
  node.child_base = address + static_cast<std::uint64_t>(static_cast<std::int64_t>(offset)) * unit_;
  const std::uint64_t children = child_bytes(layout_, bytes);
  for (unsigned i = 0; i < layout_.slots; ++i) {
    const auto info = static_cast<std::uint8_t>(children >> (8 * i));
    if ((info & 3) == 0) break;
    node.kinds[i] = static_cast<NodeKind>(info >> 2);
    ++node.child_count;
  }
  for (int axis = 0; axis < 3; ++axis) {
    float origin = 0.0f;
    std::memcpy(&origin, bytes + 4 * axis, 4);
    const float step = box_step(static_cast<std::int8_t>(bytes[18 + axis]));
    std::uint8_t lower[traces::kMaxWidth], upper[traces::kMaxWidth];
    read_codes(layout_, bytes, 2 * static_cast<unsigned>(axis), lower);
    read_codes(layout_, bytes, 2 * static_cast<unsigned>(axis) + 1, upper);
    for (unsigned i = 0; i < node.child_count; ++i) {
      node.boxes[i].lower[axis] = decode_bound(origin, lower[i], step);
      node.boxes[i].upper[axis] = decode_bound(origin, upper[i], step);
    }
  }
  return node;
}

}  // namespace grtx::frontend
