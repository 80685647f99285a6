// SPDX-License-Identifier: Apache-2.0
#include "grtx/traces/decoded_size.h"

#include "grtx/base/free_memory.h"
#include "grtx/traces/byte_stream.h"

namespace grtx::traces {

void take_memory(std::uint64_t bytes) {
  constexpr std::uint64_t kAskEvery = std::uint64_t{8} << 20;
  thread_local std::uint64_t unasked = 0;
  unasked += bytes;
  if (unasked < kAskEvery) return;
  const std::string fault = memory_fault(unasked);
  unasked = 0;
  if (!fault.empty()) throw Malformed(fault + ", to be decoded");
}

}  // namespace grtx::traces
