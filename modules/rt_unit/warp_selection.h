// Which warp of the warp buffer the RT scheduler serves: a policy, free of SystemC.
#pragma once

#include <bit>
#include <cassert>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/base/named_enum.h"
#include "grtx/base/strong.h"

namespace grtx::modules {

class WarpSelection {
 public:
  virtual ~WarpSelection() = default;
  /// candidates: one bit an entry, not 0. ages: acceptance number of the warp in each entry. Returns the chosen entry.
  virtual unsigned select(LaneMask candidates, const std::vector<std::uint64_t>& ages) = 0;
};

/// The warp that entered the buffer first (Vulkan-Sim).
class OldestFirst final : public WarpSelection {
 public:
  unsigned select(LaneMask candidates, const std::vector<std::uint64_t>& ages) override {
    return oldest(candidates, ages);
  }
  static unsigned oldest(LaneMask candidates, const std::vector<std::uint64_t>& ages) {
    assert(candidates != 0);
    auto best = static_cast<unsigned>(std::countr_zero(candidates));
    for (LaneMask m = candidates & (candidates - 1); m != 0; m &= m - 1) {
      const auto e = static_cast<unsigned>(std::countr_zero(m));
      if (ages[e] < ages[best]) best = e;
    }
    return best;
  }
};

/// The next entry after the one served last, by entry number.
class RoundRobin final : public WarpSelection {
 public:
  unsigned select(LaneMask candidates, const std::vector<std::uint64_t>&) override {
    assert(candidates != 0);
    const LaneMask after = last_ >= 63 ? 0 : candidates & (~LaneMask{0} << (last_ + 1));
    last_ = static_cast<unsigned>(std::countr_zero(after != 0 ? after : candidates));
    return last_;
  }

 private:
  unsigned last_ = 63;
};

/// The warp served last as long as it is a candidate, else the oldest.
class GreedyThenOldest final : public WarpSelection {
 public:
  unsigned select(LaneMask candidates, const std::vector<std::uint64_t>& ages) override {
    const bool stays = served_ && (candidates >> entry_ & 1) != 0 && ages[entry_] == age_;
    if (!stays) entry_ = OldestFirst::oldest(candidates, ages);
    age_ = ages[entry_];
    served_ = true;
    return entry_;
  }

 private:
  bool served_ = false;
  unsigned entry_ = 0;
  std::uint64_t age_ = 0;
};

/// The registered policies.
inline std::vector<std::string> warp_selection_names() { return {"oldest_first", "round_robin", "greedy_then_oldest"}; }

/// By its name; anything else is an Error.
inline std::unique_ptr<WarpSelection> make_warp_selection(std::string_view name) {
  if (name == "oldest_first") return std::make_unique<OldestFirst>();
  if (name == "round_robin") return std::make_unique<RoundRobin>();
  if (name == "greedy_then_oldest") return std::make_unique<GreedyThenOldest>();
  throw Error("configuration", "rt.scheduler.policy", unknown_name(name, warp_selection_names()));
}

}  // namespace grtx::modules
