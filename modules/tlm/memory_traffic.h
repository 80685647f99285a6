// What a memory was asked for and what it answered.
#pragma once

#include <cstdint>

namespace grtx::modules {

struct MemoryTraffic {
  std::uint64_t reads = 0;      ///< requests
  std::uint64_t writes = 0;     ///< requests
  std::uint64_t bytes = 0;      ///< of both
  std::uint64_t responses = 0;  ///< begun
  std::uint64_t refused = 0;    ///< responses with an error status

  MemoryTraffic& operator+=(const MemoryTraffic& other) {
    reads += other.reads;
    writes += other.writes;
    bytes += other.bytes;
    responses += other.responses;
    refused += other.refused;
    return *this;
  }
};

}  // namespace grtx::modules
