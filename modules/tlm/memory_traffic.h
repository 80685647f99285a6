// SPDX-License-Identifier: Apache-2.0
// Counters of the requests to and responses from a memory.
#pragma once

#include <cstdint>

namespace grtx::modules {

struct MemoryTraffic {
  std::uint64_t reads = 0;      ///< requests
  std::uint64_t writes = 0;     ///< requests
  std::uint64_t bytes = 0;      ///< read and written
  std::uint64_t responses = 0;  ///< responses begun
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
