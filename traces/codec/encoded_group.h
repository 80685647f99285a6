// A group as it stands in the file.
#pragma once

#include <cstdint>

#include "grtx/traces/codec/byte_stream.h"
#include "grtx/traces/header.h"

namespace grtx::traces {

/// Ready for Writer::append().
struct EncodedGroup {
  std::uint32_t index = 0;
  Bytes chunk;  ///< as in the file
  Totals totals;
};

}  // namespace grtx::traces
