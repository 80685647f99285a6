#include "grtx/modules/rt_unit/decide/stack_prefetch.h"

namespace grtx::modules {

StackPrefetch::StackPrefetch(std::size_t lanes, const Config& config, const NodeTraffic& traffic)
    : config_(config), traffic_(traffic), lanes_(config.depth > 0 ? lanes : 0) {}

void StackPrefetch::begin(std::size_t lane, const traces::RayGroup& group, std::span<const traces::Event> events) {
  lanes_[lane].stack.begin(group, events, traffic_);
  lanes_[lane].pops = 0;
}

bool StackPrefetch::triggered(Lane& lane, const EventEffect& effect) const {
  const bool rises = effect.popped() > 0 && effect.pushed() == 0;
  lane.pops = rises ? lane.pops + 1 : 0;
  return config_.trigger == StackTrigger::pop ? lane.pops >= config_.pops : effect.pushed() > 1;
}

}  // namespace grtx::modules
