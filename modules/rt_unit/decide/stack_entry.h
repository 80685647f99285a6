// What an entry of a lane's traversal stack holds: the node's address, and its t where popped nodes are tested against
// t_max (Header::pop_test). The paper gives no layout. Storage, spills and stack areas follow from here.
#pragma once

#include <bit>

#include "grtx/modules/messages/memory_request.h"
#include "grtx/traces/modes.h"

namespace grtx::modules {

struct StackEntryLayout {
  unsigned bits;         ///< in the warp buffer
  unsigned bytes;        ///< in memory: padded, so that entries divide a sector
  unsigned in_a_sector;  ///< entries that move together
};

constexpr StackEntryLayout stack_entry_layout(traces::PopTest pop_test) {
  const unsigned bits = 64 + (pop_test == traces::PopTest::on ? 32 : 0);  // address, fp32
  const unsigned bytes = std::bit_ceil(bits / 8);
  return {bits, bytes, static_cast<unsigned>(kSectorBytes) / bytes};
}

}  // namespace grtx::modules
