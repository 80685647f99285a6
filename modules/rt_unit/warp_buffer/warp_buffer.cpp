// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/warp_buffer/warp_buffer.h"

#include <bit>
#include <ostream>

namespace grtx::modules {

WarpBuffer::WarpBuffer(const sc_core::sc_module_name& name, const Config& config, bool checkpoint,
                       const StackEntryLayout& stack_entry, bool objects, unsigned bvh_width, unsigned ray_readers)
    : WarpBufferModule(name),
      config_(config),
      checkpoint_(checkpoint),
      stack_entry_(stack_entry),
      objects_(objects),
      bvh_width_(bvh_width),
      ray_readers_(ray_readers),
      table_(config.entries) {
  require_allowed("rt.warp_buffer", config);
}

void WarpBuffer::end_of_elaboration() {
  admission_ = admission.operator->();
  calls_ = reader_of(trace_call);
  dones_ = writer_of(trace_done);
}

void WarpBuffer::retire(Cycle now) {
  const WarpMask finished = table_.finished_entries();
  if (finished == 0 || !dones_.can_push(now)) return;
  const unsigned entry = table_.oldest(finished);
  const Warp& warp = table_.warp(entry);
  dones_.push(now, {warp.slot, warp.round});
  table_.release(now, entry);
}

void WarpBuffer::accept(Cycle now) {
  if (!table_.has_room()) return;
  const TraceCall* call = calls_.front(now);
  if (call == nullptr) return;
  const unsigned entry = table_.accept(now, *call);
  calls_.pop(now);
  admission_->begin(entry);
}

void WarpBuffer::settle(Cycle end) {
  table_.account(end);
  table_.count_waits();
  table_.settle(end);
}

std::vector<UnitProbe> WarpBuffer::probes() const {
  const unsigned warps = table_.entries();
  return {{"occupancy", static_cast<unsigned>(std::bit_width(warps)),
           [this] { return static_cast<unsigned>(std::popcount(table_.occupied())); }},
          {"ready_warps", warps, [this] { return table_.ready_entries(); }}};
}

Inventory WarpBuffer::inventory() const {
  const std::uint64_t lanes = std::uint64_t{config_.entries} * kMaxLanes;
  Inventory inventory{name(), {}, {}};
  auto& storage = inventory.storage;
  constexpr unsigned kRayBits = 8 * 32;  // origin, direction, t_min, t_max
  storage.push_back({"ray", StorageKind::ram, lanes * kRayBits});
  if (config_.ray_banks != 0) {
    storage.back() = {"ray", StorageKind::ram, lanes * kRayBits, ray_readers_, 1, false, kRayBits, config_.ray_banks};
  }
  storage.push_back({"hit", StorageKind::ram, lanes * 2 * 32});   // t_hit, primitive id
  storage.push_back({"instance", StorageKind::ram, lanes * 64});  // address of the TLAS leaf the ray is inside
  if (stack_entry_.bits != 0) {
    storage.push_back({"stack", StorageKind::ram, lanes * config_.on_chip_entries(bvh_width_) * stack_entry_.bits});
  }
  storage.push_back({"status", StorageKind::flip_flop, lanes * 4});  // ten lane states
  storage.push_back({"warp", StorageKind::flip_flop, std::uint64_t{config_.entries} * (16 + 16 + kMaxLanes)});
  if (objects_) {
    // The ray in object space, to return from the BLAS to the object's TLAS without another transform. The level of a
    // node follows from its address.
    storage.push_back({"scene_instance", StorageKind::ram, lanes * 64});  // address of the leaf of the scene TLAS
    storage.push_back({"object_ray", StorageKind::ram, lanes * 6 * 32});  // origin, direction in the object's space
  }
  if (checkpoint_) {
    // Paper, "Hardware cost": (1 bit + 2 B + 2 B) per lane; per unit two base addresses and the maximum buffer size.
    storage.push_back({"replay_flag", StorageKind::ram, lanes * 1, 1, 1, true});
    storage.push_back({"source_offset", StorageKind::ram, lanes * 16, 1, 1, true});
    storage.push_back({"destination_offset", StorageKind::ram, lanes * 16, 1, 1, true});
    storage.push_back({"source_base", StorageKind::flip_flop, 64, 1, 1, true});
    storage.push_back({"destination_base", StorageKind::flip_flop, 64, 1, 1, true});
    storage.push_back({"maximum_size", StorageKind::flip_flop, 16, 1, 1, true});
  }
  return inventory;
}

void WarpBuffer::dump_state(std::ostream& out) const {
  out << name() << ": " << std::popcount(table_.occupied()) << " of " << config_.entries << " warps\n";
  table_.dump_state(out);
}

PartInfo part_info(const WarpBufferConfig&) {
  PartInfo part;
  part.name = "warp_buffer";
  part.energy = {{.name = "rt.warp_buffer",
                  .statistics = {"gpu.rt.lanes_handled"},
                  .terms = {reads("warp_buffer", "ray"), reads("warp_buffer", "stack"), writes("warp_buffer", "stack")},
                  .basis = "lane steps: a ray is read, a stack entry read and written"}};
  part.stalls = {{"empty", "a warp"}, {"retire", "the end of a warp's rays"}};
  return part;
}

}  // namespace grtx::modules
