// SPDX-License-Identifier: Apache-2.0
// Compact form of the stack pops of one kind: a correct prediction only lengthens a run; a wrong one writes the length
// of the run and the pop that it was.
#pragma once

#include <cstdint>

#include "grtx/traces/byte_stream.h"
#include "grtx/traces/codec/group_codec.h"

namespace grtx::traces {

/// Branch-free, because whether a pop is predicted is itself unpredictable for the host.
struct PopColumns {
  std::uint8_t* gap = nullptr;
  std::uint8_t* symbols = nullptr;
  unsigned run = 0;  ///< predicted pops since the last mispredicted one

  /// symbol: 0 for a predicted pop. Does not check that the columns have room.
  void put(unsigned symbol) {
    const unsigned told = symbol != 0 ? 1 : 0;
    *gap = static_cast<std::uint8_t>(run);
    *symbols = static_cast<std::uint8_t>(symbol);
    gap += told;
    symbols += told;
    run = (run + 1) & (told - 1);
    if (run == kLongGap) {
      *gap++ = kLongGap;
      run = 0;
    }
  }
};

/// Inverse of PopColumns. Throws Malformed.
class PopReader {
 public:
  void begin(const ByteReader& gaps, const ByteReader& symbols) {
    gaps_ = gaps;
    symbols_ = symbols;
    left_ = 0;
    symbol_behind_ = false;
  }
  /// Returns the symbol of the next pop; 0 if it is as predicted.
  unsigned next() {
    if (left_ == 0) return next_told();
    --left_;
    return 0;
  }
  [[noreturn]] void fail(const char* rule) const { symbols_.fail(rule); }
  void expect_end() const {
    if (left_ != 0) gaps_.fail("counts more pops than there are");
    gaps_.expect_end();
    symbols_.expect_end();
  }

 private:
  unsigned next_told() {
    if (!symbol_behind_) {
      left_ = gaps_.u8();
      symbol_behind_ = left_ != kLongGap;
      if (left_ != 0) {
        --left_;
        return 0;
      }
    }
    symbol_behind_ = false;
    const unsigned symbol = symbols_.u8();
    if (symbol == 0) symbols_.fail("holds a pop that was predicted");
    return symbol;
  }

  ByteReader gaps_;
  ByteReader symbols_;
  unsigned left_ = 0;           ///< predicted pops left in the run
  bool symbol_behind_ = false;  ///< whether a mispredicted pop follows the run
};

}  // namespace grtx::traces
