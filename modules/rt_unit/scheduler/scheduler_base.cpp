// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/scheduler/scheduler_base.h"

#include <string>

#include "grtx/base/error.h"

namespace grtx::modules {

SchedulerBase::SchedulerBase(const sc_core::sc_module_name& name, const RtSchedulerConfig& config, unsigned entries,
                             bool boxes)
    : RtSchedulerModule(name),
      config_(config),
      selection_(make_warp_selection(config.policy)),
      entries_(entries),
      boxes_(boxes) {}

void SchedulerBase::end_of_elaboration() {
  buffer_ = &warp_buffer->warps();
  memory_ = node_fetch.operator->();
  traffic_ = &memory_->traffic();
  any_hit_ = any_hit.operator->();
  if (checkpoint.size() > 0) checkpoint_ = checkpoint.operator->();
  if (stack.size() > 0) stack_ = stack.operator->();
}

void SchedulerBase::restart() {
  selection_ = make_warp_selection(config_.policy);
  counters_ = {};
}

unsigned SchedulerBase::entry_of_answer(const AnyHitDone& done) const {
  const unsigned entry = buffer_->find_slot(done.slot);
  if (entry == buffer_->entries() || (done.lanes & ~buffer_->warp(entry).in_state(LaneState::in_any_hit)) != 0) {
    throw Error("any-hit", "slot " + std::to_string(done.slot), "only lanes at the shader can be done");
  }
  return entry;
}

void SchedulerBase::refuse(LaneId id, const char* rule) const {
  throw Error("trace", place_in_trace(buffer_->warp(entry_of(id)), lane_of(id)), rule);
}

}  // namespace grtx::modules
