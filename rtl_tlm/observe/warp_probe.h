// SPDX-License-Identifier: Apache-2.0
// Watches one entry of a warp buffer: its warp, the lanes, and the node, k-buffer and t_max known from their events.
#pragma once

#include <array>
#include <string>

#include "grtx/modules/rt_unit/checkpoint/checkpoint_unit.h"
#include "grtx/modules/rt_unit/decide/node_traffic.h"
#include "grtx/modules/rt_unit/warp_buffer/warp_table.h"
#include "grtx/rtl_tlm/observe/wires.h"
#include "grtx/traces/header.h"

namespace grtx::sim {

class WarpProbe {
 public:
  /// scope: that of the warp buffer. checkpoint: null if the unit is not elaborated. All must outlive the probe.
  WarpProbe(Wires& wires, const std::string& scope, const modules::WarpTable& buffer, unsigned entry,
            const modules::CheckpointState* checkpoint, const traces::Header& header);

  void sample();

 private:
  void begin();
  void follow_lane(unsigned lane);
  void show_node();
  void show_walk(const modules::Warp& warp);
  void show_offsets();
  void clear();

  const modules::WarpTable& buffer_;
  const modules::CheckpointState* checkpoint_;
  unsigned entry_;
  unsigned k_;
  modules::NodeTraffic traffic_;
  bool selected_ = false;

  // The state that the wires show, to find what has changed.
  bool occupied_ = false;
  std::uint64_t age_ = 0;
  std::array<LaneMask, modules::kLaneStates> in_{};
  std::array<const traces::Event*, modules::kMaxLanes> next_{};  ///< the lane's next event
  std::array<std::uint16_t, modules::kMaxLanes> fill_{};         ///< entries in a lane's k-buffer
  LaneMask lowered_ = 0;                                         ///< lanes whose t_max a reported hit has lowered

  Wire state_, slot_, group_, round_, active_, replay_, node_kind_, node_address_, node_lanes_, t_min_rank_,
      t_max_lowered_, k_fill_, source_offset_, destination_offset_;
  std::array<Wire, modules::kLaneStates> lanes_;
};

}  // namespace grtx::sim
