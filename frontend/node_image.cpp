#include "frontend/node_image.h"

#include <cassert>
#include <cmath>
#include <stdexcept>

namespace grtx::frontend {
namespace {

constexpr float kLargest = std::numeric_limits<float>::max();

// 2^(exponent - 8) as fp32 (exponents reach below the normal range for tiny boxes).
float step_of(int exponent) { return std::ldexp(1.0f, exponent - 8); }

float decode(float origin, std::uint8_t q, float step) { return origin + static_cast<float>(q) * step; }

struct AxisCode {
  float origin = 0.0f;
  int exponent = -128;
  std::array<std::uint8_t, traces::kMaxWidth> lower{};
  std::array<std::uint8_t, traces::kMaxWidth> upper{};
};

// Finds the smallest exponent with which every child's bounds fit into `bits` bits after outward rounding, checked in the
// very arithmetic of the decoder. Codes are multiples of `quantum`.
AxisCode encode_axis(const ChildRecord* children, unsigned count, int axis, unsigned bits) {
  const int quantum = 1 << (8 - bits);
  const int largest = 256 - quantum;
  AxisCode code;
  code.origin = kLargest;
  float highest = -kLargest;
  for (unsigned i = 0; i < count; ++i) {
    code.origin = std::min(code.origin, children[i].box.lower[axis]);
    highest = std::max(highest, children[i].box.upper[axis]);
  }
  const double extent = static_cast<double>(highest) - static_cast<double>(code.origin);
  int exponent = -128;
  if (extent > 0.0) {
    std::frexp(extent, &exponent);
    exponent = std::max(exponent, -128);
  }
  for (;; ++exponent) {
    if (exponent > 127) throw std::overflow_error("child box does not fit the encoding");
    const float step = step_of(exponent);
    bool fits = true;
    for (unsigned i = 0; i < count && fits; ++i) {
      const double scale = static_cast<double>(step);
      const double low = (static_cast<double>(children[i].box.lower[axis]) - static_cast<double>(code.origin)) / scale;
      const double high = (static_cast<double>(children[i].box.upper[axis]) - static_cast<double>(code.origin)) / scale;
      int lower = static_cast<int>(std::floor(std::min(low, 256.0)));
      int upper = static_cast<int>(std::ceil(std::min(high, 256.0)));
      while (lower > 0 && (lower > 255 || decode(code.origin, static_cast<std::uint8_t>(lower), step) >
                                              children[i].box.lower[axis])) {
        --lower;
      }
      while (upper <= 255 &&
             decode(code.origin, static_cast<std::uint8_t>(upper), step) < children[i].box.upper[axis]) {
        ++upper;
      }
      lower -= lower % quantum;
      upper = (upper + quantum - 1) / quantum * quantum;
      fits = upper <= largest;
      code.lower[i] = static_cast<std::uint8_t>(lower);
      code.upper[i] = static_cast<std::uint8_t>(upper);
    }
    if (fits) break;
  }
  code.exponent = exponent;
  return code;
}

}  // namespace

std::uint64_t NodeImage::allocate(std::uint64_t count) {
  assert(count % traces::kNodeUnit == 0 && used_ + count <= size());
  const std::uint64_t address = used_;
  used_ += count;
  return address;
}

void NodeImage::write_header(std::uint64_t address, std::uint64_t root, const Box& bounds) {
  put<std::uint64_t>(address, root);
  for (int i = 0; i < 3; ++i) {
    put(address + 8 + 4 * static_cast<std::uint64_t>(i), bounds.lower[i]);
    put(address + 20 + 4 * static_cast<std::uint64_t>(i), bounds.upper[i]);
  }
}

void NodeImage::write_internal(std::uint64_t address, std::uint64_t child_base, const ChildRecord* children,
                               unsigned count) {
  assert(count <= width_);
  put(address + 12, static_cast<std::int32_t>((child_base - address) / traces::kNodeUnit));
  put<std::uint8_t>(address + 16, static_cast<std::uint8_t>(NodeKind::internal));
  put<std::uint8_t>(address + 17, 0);
  put<std::uint8_t>(address + 21, 0xFF);
  for (unsigned i = 0; i < layout_.slots; ++i) {
    if (i >= count) {
      put<std::uint8_t>(address + layout_.child_info + i, 0);  // the bytes may have held another node
      continue;
    }
    const auto units = traces::node_bytes(children[i].kind, width_) / traces::kNodeUnit;
    put<std::uint8_t>(address + layout_.child_info + i,
                      static_cast<std::uint8_t>(units | (static_cast<std::uint64_t>(children[i].kind) << 2)));
  }
  for (int axis = 0; axis < 3; ++axis) {
    const AxisCode code = count > 0 ? encode_axis(children, count, axis, box_bits_) : AxisCode{};
    put(address + 4 * static_cast<std::uint64_t>(axis), code.origin);
    put<std::int8_t>(address + 18 + static_cast<std::uint64_t>(axis), static_cast<std::int8_t>(code.exponent));
    const std::uint64_t lower = address + layout_.bounds + 2 * static_cast<std::uint64_t>(axis) * layout_.slots;
    for (unsigned i = 0; i < layout_.slots; ++i) {
      put<std::uint8_t>(lower + i, i < count ? code.lower[i] : 0x80);
      put<std::uint8_t>(lower + layout_.slots + i, i < count ? code.upper[i] : 0x00);
    }
  }
}

void NodeImage::write_triangle(std::uint64_t address, std::uint32_t primitive, const glm::vec3& a, const glm::vec3& b,
                               const glm::vec3& c) {
  put<std::uint32_t>(address, 0xFF000000u);
  put<std::uint32_t>(address + 8, primitive);
  leaf_index_[address / traces::kNodeUnit] = primitive;
  const glm::vec3 vertices[4] = {a, b, c, c};
  for (std::uint64_t v = 0; v < 4; ++v) {
    for (std::uint64_t i = 0; i < 3; ++i) put(address + 16 + 12 * v + 4 * i, vertices[v][static_cast<int>(i)]);
  }
}

void NodeImage::write_procedural(std::uint64_t address, std::uint32_t primitive) {
  put<std::uint32_t>(address, 0xFF000000u);
  put<std::uint32_t>(address + 4, 1u << 29);
  put<std::uint32_t>(address + 8, 1u);
  put<std::uint32_t>(address + 12, primitive);
  leaf_index_[address / traces::kNodeUnit] = primitive;
}

void NodeImage::write_instance(std::uint64_t address, std::uint32_t instance, std::uint64_t blas_header,
                               std::uint64_t blas_root, const glm::vec3 (&world_to_object)[3],
                               const glm::vec3 (&object_to_world)[3], const glm::vec3& translation) {
  put<std::uint32_t>(address, 0xFF000000u | (instance & 0xFFFFFFu));
  put<std::uint32_t>(address + 4, 0);
  put<std::uint64_t>(address + 8, blas_root);
  glm::vec3 object_translation(0.0f);
  for (std::uint64_t row = 0; row < 3; ++row) {
    for (std::uint64_t i = 0; i < 3; ++i) {
      put(address + 16 + 12 * row + 4 * i, world_to_object[row][static_cast<int>(i)]);
      put(address + 80 + 12 * row + 4 * i, object_to_world[row][static_cast<int>(i)]);
    }
    const glm::vec3& m = world_to_object[row];
    object_translation[static_cast<int>(row)] = -(m.x * translation.x + m.y * translation.y + m.z * translation.z);
  }
  for (std::uint64_t i = 0; i < 3; ++i) {
    put(address + 52 + 4 * i, translation[static_cast<int>(i)]);
    put(address + 116 + 4 * i, object_translation[static_cast<int>(i)]);
  }
  put<std::uint64_t>(address + 64, blas_header);
  put<std::uint32_t>(address + 72, instance);
  put<std::uint32_t>(address + 76, instance);
  leaf_index_[address / traces::kNodeUnit] = instance;
}

DecodedInternal NodeImage::decode_internal(std::uint64_t address) const {
  DecodedInternal node;
  const std::uint8_t* bytes = data() + address;
  std::int32_t offset = 0;
  std::memcpy(&offset, bytes + 12, 4);
  node.child_base = address + static_cast<std::uint64_t>(static_cast<std::int64_t>(offset)) * traces::kNodeUnit;
  for (unsigned i = 0; i < layout_.slots; ++i) {
    const std::uint8_t info = bytes[layout_.child_info + i];
    if ((info & 3) == 0) break;
    node.kinds[i] = static_cast<NodeKind>(info >> 2);
    ++node.child_count;
  }
  for (int axis = 0; axis < 3; ++axis) {
    float origin = 0.0f;
    std::memcpy(&origin, bytes + 4 * axis, 4);
    const float step = step_of(static_cast<std::int8_t>(bytes[18 + axis]));
    const std::uint8_t* lower = bytes + layout_.bounds + 2 * static_cast<unsigned>(axis) * layout_.slots;
    for (unsigned i = 0; i < node.child_count; ++i) {
      node.boxes[i].lower[axis] = decode(origin, lower[i], step);
      node.boxes[i].upper[axis] = decode(origin, lower[layout_.slots + i], step);
    }
  }
  return node;
}

}  // namespace grtx::frontend
