// SPDX-License-Identifier: Apache-2.0
// `grtx` with three policies of its own, each a value of its key (docs/guide/use-the-libraries.md):
//   own_policy sim TRACE.grtx --set l2.replacement=keep_nodes --set gpu.distribution=blocks --set gpu.blocks.groups=4
#include <algorithm>
#include <bit>
#include <memory>
#include <vector>

#include "grtx/apps/grtx/program.h"
#include "grtx/modules/cache/decide/replacement.h"
#include "grtx/modules/rt_unit/scheduler/decide/warp_selection.h"
#include "grtx/modules/simt/decide/work_distribution.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

using namespace grtx;
using namespace grtx::modules;

namespace {

/// The warp of which most lanes would be served; of equals the one that would drop or visit leaves first, then the
/// oldest.
class Fullest final : public WarpSelection {
 public:
  unsigned select(LaneMask candidates, const std::vector<std::uint64_t>& ages, const SelectableWarps& warps) override {
    unsigned best = 0;
    std::uint64_t best_rank = 0;
    for (LaneMask left = candidates; left != 0; left &= left - 1) {
      const auto entry = static_cast<unsigned>(std::countr_zero(left));
      const SelectableWarp warp = warps.at(entry);
      const std::uint64_t rank = 64u * warp.active() + warp.next(NextStep::leaf) + warp.next(NextStep::other) + 1;
      if (rank < best_rank || (rank == best_rank && ages[entry] > ages[best])) continue;
      best = entry;
      best_rank = rank;
    }
    return best;
  }
};

/// What is no node goes first; of equals what was used longest ago.
class KeepNodes final : public CacheReplacement {
 public:
  KeepNodes(std::uint64_t sets, unsigned ways) : ways_(ways), lines_(sets * ways) {}
  void filled(std::uint64_t set, unsigned way, const MemoryRequest& access) override { use(set, way, access); }
  void referenced(std::uint64_t set, unsigned way, const MemoryRequest& access) override { use(set, way, access); }
  unsigned victim(std::uint64_t set, const MemoryRequest&) const override {
    const auto first = lines_.begin() + static_cast<std::ptrdiff_t>(set * ways_);
    const auto worse = [](const Line& a, const Line& b) { return a.node != b.node ? !a.node : a.used < b.used; };
    return static_cast<unsigned>(std::min_element(first, first + ways_, worse) - first);
  }
  unsigned bits_per_line() const override { return 1 + static_cast<unsigned>(std::bit_width(ways_ - 1)); }

 private:
  struct Line {
    std::uint64_t used = 0;
    bool node = false;
  };
  void use(std::uint64_t set, unsigned way, const MemoryRequest& access) {
    lines_[set * ways_ + way] = {++time_, is_node(access.region)};
  }
  unsigned ways_;
  std::uint64_t time_ = 0;
  std::vector<Line> lines_;
};

/// The keys of the GPU that was built last.
struct BlocksKeys {
  unsigned groups = 8;
  void parameters(ParameterList& list) { list.add("groups", groups, {1, 1e6}, "groups", "in a row to an SM", kOurs); }
} blocks;

/// Some groups in a row, neighbours in the picture, go to one SM; where it has no room, to the one with most.
class Blocks final : public WorkDistribution {
 public:
  unsigned choose(const traces::RayGroup& group, const std::vector<unsigned>& room) override {
    const std::size_t sm = group.index / blocks.groups % room.size();
    if (room[sm] != 0) return static_cast<unsigned>(sm);
    return static_cast<unsigned>(std::max_element(room.begin(), room.end()) - room.begin());
  }
};

}  // namespace

int sc_main(int argc, char** argv) {
  register_warp_selection("fullest", [] { return std::make_unique<Fullest>(); });
  register_cache_replacement("keep_nodes",
                             [](std::uint64_t sets, unsigned ways) { return std::make_unique<KeepNodes>(sets, ways); });
  register_work_distribution("blocks", [](unsigned) { return std::make_unique<Blocks>(); });
  OwnKeys::add<BlocksKeys>("gpu.blocks");
  sim::register_parts([](const sim::GpuConfig& gpu, sim::GpuParts&) { blocks = gpu.own.get<BlocksKeys>(); });
  return grtx::program(argc, argv, grtx::kMachinesFolder);
}
