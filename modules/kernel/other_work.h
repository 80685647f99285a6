// Cycles of a resource that something else than ray tracing takes: a share of them, each by itself, drawn by a hash of
// the cycle's number. docs/model/other-work.md. Free of SystemC.
#pragma once

#include <cstdint>

#include "grtx/base/strong.h"
#include "grtx/modules/kernel/declare.h"

namespace grtx::modules {

/// What is shared; with the number of the unit it names the stream of draws.
enum class SharedResource : std::uint8_t { issue = 1, l1 = 2, dram = 3 };

class OtherWork {
 public:
  static constexpr Range kShares{0.0, 0.9};

  OtherWork() = default;
  /// share: of the cycles, 0 to 0.9. unit: which of these resources.
  OtherWork(double share, SharedResource resource, std::uint64_t unit)
      : threshold_(static_cast<std::uint64_t>(share * 4294967296.0)),
        stream_((static_cast<std::uint64_t>(resource) << 32 | unit) * 0x9E3779B97F4A7C15ULL) {}

  explicit operator bool() const { return threshold_ != 0; }
  /// Whether other work has that cycle.
  bool takes(Cycle cycle) const { return threshold_ != 0 && hash(stream_ + cycle) >> 32 < threshold_; }
  /// The first cycle from `from` on that it leaves.
  Cycle free_from(Cycle from) const {
    while (takes(from)) ++from;
    return from;
  }
  /// The last of the first `count` cycles from `from` on that it leaves; count: 1 or more.
  Cycle last_of(Cycle from, std::uint64_t count) const {
    if (threshold_ == 0) return from + count - 1;
    for (from = free_from(from); count > 1; --count) from = free_from(from + 1);
    return from;
  }

 private:
  /// The finaliser of splitmix64.
  static std::uint64_t hash(std::uint64_t z) {
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ z >> 27) * 0x94D049BB133111EBULL;
    return z ^ z >> 31;
  }

  std::uint64_t threshold_ = 0;  ///< of 2^32
  std::uint64_t stream_ = 0;
};

}  // namespace grtx::modules
