#include "grtx/rtl_tlm/observe/wave_enumerations.h"

#include <map>
#include <string>

#include "grtx/modules/simt/simt_counters.h"
#include "grtx/rtl_tlm/observe/stall_follower.h"

namespace grtx::sim {

WarpState state_of(const modules::Warp& warp) {
  using modules::LaneState;
  if (warp.in_state(LaneState::ready) != 0) return WarpState::ready;
  if (warp.in_state(LaneState::waiting_memory) != 0) return WarpState::memory;
  if (warp.in_state(LaneState::in_unit) != 0) return WarpState::unit;
  if ((warp.in_state(LaneState::waiting_checkpoint_read) | warp.in_state(LaneState::waiting_checkpoint_write)) != 0) {
    return WarpState::checkpoint;
  }
  if (warp.in_state(LaneState::waiting_stack) != 0) return WarpState::stack;
  if ((warp.in_state(LaneState::waiting_any_hit) | warp.in_state(LaneState::in_any_hit)) != 0)
    return WarpState::any_hit;
  return WarpState::finished;
}

const Enumeration& warp_states() {
  static const Enumeration states{
      "warp_state",
      {"free", "ready", "memory", "unit", "checkpoint", "stack", "any_hit", "finished"},
      {"gray25", "forest green", "royal blue", "dark goldenrod", "purple", "maroon", "firebrick", "gray50"}};
  return states;
}

const Enumeration& stall_reasons() {
  static const Enumeration reasons = [] {
    const std::map<std::string, std::string> colours = {
        {"none", "forest green"}, {"empty", "gray25"},        {"queue_full", "orange red"}, {"memory", "royal blue"},
        {"checkpoint", "purple"}, {"unit", "dark goldenrod"}, {"any_hit", "firebrick"},     {"retire", "gray50"}};
    Enumeration e{"stall_reason", StallFollower::names(), {}};
    for (const std::string& value : e.values) {
      const auto colour = colours.find(value);
      e.colours.push_back(colour == colours.end() ? "maroon" : colour->second);
    }
    return e;
  }();
  return reasons;
}

const Enumeration& unit_states() {
  static const Enumeration states{
      "unit_state", {"idle", "busy", "waiting"}, {"gray25", "forest green", "dark goldenrod"}};
  return states;
}

const Enumeration& node_kinds() {
  static const Enumeration kinds{"node_kind",
                                 {"none", "internal", "instance", "triangle", "procedural"},
                                 {"gray25", "royal blue", "purple", "forest green", "forest green"}};
  return kinds;
}

const Enumeration& activities() {
  static const Enumeration activities = [] {
    Enumeration e{"activity",
                  {"free"},
                  {"gray25", "dark goldenrod", "forest green", "firebrick", "royal blue", "steel blue", "gray50"}};
    for (const auto name : modules::kWarpActivityNames) e.values.emplace_back(name);
    return e;
  }();
  return activities;
}

}  // namespace grtx::sim
