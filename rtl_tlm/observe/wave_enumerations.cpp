// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/observe/wave_enumerations.h"

#include <map>
#include <string>

#include "grtx/modules/rt_unit/warp_buffer/warp_table.h"
#include "grtx/modules/simt/decide/simt_core_config.h"
#include "grtx/rtl_tlm/observe/stall_follower.h"

namespace grtx::sim {

const Enumeration& warp_states() {
  static const Enumeration states = [] {
    Enumeration e{
        "warp_state",
        {"free"},
        {"gray25", "forest green", "royal blue", "purple", "maroon", "dark goldenrod", "firebrick", "gray50"}};
    for (const std::string& name : names_of<modules::WarpWait>()) e.values.emplace_back(name);
    return e;
  }();
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
    for (const std::string& name : names_of<modules::WarpActivity>()) e.values.emplace_back(name);
    return e;
  }();
  return activities;
}

}  // namespace grtx::sim
