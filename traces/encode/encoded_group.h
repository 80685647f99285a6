// SPDX-License-Identifier: Apache-2.0
// A group encoded as in the file.
#pragma once

#include <cstdint>

#include "grtx/traces/byte_stream.h"
#include "grtx/traces/header.h"

namespace grtx::traces {

/// Ready for Writer::append().
struct EncodedGroup {
  std::uint32_t index = 0;
  Bytes chunk;  ///< bytes of the chunk in the file
  Totals totals;
};

}  // namespace grtx::traces
