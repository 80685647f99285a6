// SPDX-License-Identifier: Apache-2.0
// Memory messages between the RT unit, the SIMT core and the memory hierarchy: one 32 B sector per request.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <string_view>

#include "grtx/base/declare/named_enum.h"

namespace grtx::modules {

inline constexpr std::uint64_t kSectorBytes = 32;
inline constexpr unsigned kAddressBits = 40;  ///< width of a byte address in hardware
/// Addresses that the model can simulate lie below: 128 GiB without the last sector. Its caches number sectors in 32
/// bits (AddressIndex).
inline constexpr std::uint64_t kAddressable = (std::uint64_t{0xFFFF'FFFF}) * kSectorBytes;
/// Whether all of [address, address + bytes) lies below `limit`, without wrapping around.
constexpr bool lies_below(std::uint64_t limit, std::uint64_t address, std::uint64_t bytes) {
  return bytes <= limit && address <= limit - bytes;
}
inline constexpr const char* kSectorsRule = "must be 1, 2 or 4: a line has four sectors";  ///< for port widths

/// Kind of the data that a memory request accesses; caches count hits per region.
enum class Region : std::uint8_t {
  tlas,        ///< internal nodes of the monolithic BVH or the TLAS, and their headers
  blas,        ///< nodes of the shared BLAS
  leaf,        ///< triangle or procedural leaves of a monolithic BVH
  instance,    ///< TLAS instance leaves
  checkpoint,  ///< checkpoint buffers
  eviction,    ///< eviction buffers
  k_buffer,
  gaussian,  ///< Gaussian records read when blending
  sh,        ///< SH coefficients read when blending, and colours made of them
  ray,       ///< ray generation input and frame buffer
  stack,     ///< traversal stack entries beyond the warp buffer
};
constexpr auto enum_names(Region) {
  return names_in_order<Region>(
      {"tlas", "blas", "leaf", "instance", "checkpoint", "eviction", "k_buffer", "gaussian", "sh", "ray", "stack"});
}
inline constexpr std::size_t kRegionCount = kCountOf<Region>;
/// Index of a region in arrays of kRegionCount elements.
constexpr std::size_t index(Region r) { return static_cast<std::size_t>(r); }
/// The regions that count as node fetches.
constexpr bool is_node(Region r) { return r <= Region::instance; }
/// Regions that the ray generation shader accesses besides its buffers: Gaussian records, colours, pixels.
constexpr bool is_shader_data(Region r) { return r == Region::gaussian || r == Region::sh || r == Region::ray; }

/// Buffers private to one ray or warp: nobody else reads them, and their contents are dead when it ends.
constexpr bool is_private(Region r) {
  return r == Region::checkpoint || r == Region::eviction || r == Region::k_buffer || r == Region::stack;
}

/// address: byte address in the flat GPU address space, a multiple of kSectorBytes. Every request gets one response.
struct MemoryRequest {
  std::uint64_t address = 0;
  std::uint32_t tag = 0;    ///< chosen by the requester, returned in the response
  std::uint8_t client = 0;  ///< port of the L1 that issued it
  std::uint8_t sm = 0;      ///< set by the L1 when a miss leaves the SM
  Region region = Region::tlas;
  bool write : 1 = false;  // bit fields keep the request at 16 B
  bool prefetch : 1 = false;
  bool write_back : 1 = false;  ///< eviction by the L1: no client waits for the acknowledgement
};

/// Which SM a memory access is for, and its region.
struct RequestOrigin {
  static constexpr std::uint8_t kNobody = 255;
  std::uint8_t sm = kNobody;  ///< kNobody: a write-back of a cache, or unknown
  Region region = Region::tlas;
};

struct MemoryResponse {
  std::uint64_t address = 0;
  std::uint32_t tag = 0;
  std::uint8_t client = 0;
  std::uint8_t sm = 0;
  Region region = Region::tlas;
  bool write : 1 = false;
  bool prefetch : 1 = false;
  bool write_back : 1 = false;
};
static_assert(sizeof(MemoryRequest) == 16 && sizeof(MemoryResponse) == 16);

/// The members of both are the same, in the same order: 16 B are copied, not eight members.
inline MemoryResponse response_to(const MemoryRequest& r) { return std::bit_cast<MemoryResponse>(r); }

}  // namespace grtx::modules
