// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/stack/stack_unit.h"

#include <cassert>
#include <ostream>

#include "grtx/base/error.h"

namespace grtx::modules {

const CounterTable<StackCounters>& StackCounters::table() {
  using C = StackCounters;
  static const CounterTable<C> table =
      CounterTable<C>()
          .sum(&C::spills, "spills", "requests", "32 B writes of stack entries that the warp buffer has no place for")
          .sum(&C::fills, "fills", "requests", "32 B reads of stack entries from memory")
          .largest(&C::max_spilled, "max_spilled", "entries", "most stack entries of a lane in memory")
          .sum(&C::moved_out)
          .sum(&C::moved_in)
          .sum(&C::acknowledged)
          .sum(&C::returned);
  return table;
}

StackUnit::StackUnit(const sc_core::sc_module_name& name, unsigned on_chip, const StackEntryLayout& entry,
                     const MemoryMap& map, unsigned warps, unsigned sm, unsigned stacks_of_a_warp)
    : StackModule(name),
      spill_(on_chip, entry.in_a_sector),
      map_(map),
      sm_(sm),
      lanes_(std::size_t{warps} * kMaxLanes),
      stacks_(std::uint64_t{warps} * stacks_of_a_warp),
      queue_(std::size_t{warps} * kMaxLanes) {
  awake_ = false;
}

void StackUnit::end_of_elaboration() {
  client_ = client.operator->();
  requests_ = writer_of(request);
  responses_ = reader_of(response);
}

void StackUnit::begin_lane(LaneId id, std::uint16_t slot) {
  lanes_[id] = {};
  lanes_[id].ray = map_.ray_slot(sm_, slot, lane_of(id));
}

bool StackUnit::settle(LaneId id, std::uint32_t depth, bool takes_top) {
  LaneContext& lane = lanes_[id];
  assert(lane.to_spill == 0 && depth >= lane.stack.in_memory);
  const StackSpill::Move move = spill_.settle(lane.stack, depth, takes_top);
  if (!move.any()) return false;
  lane.next = move.first;
  lane.to_spill = static_cast<std::uint8_t>(move.spills);
  count_move(lane.stack, move);
  queue_.push(id);
  awake_ = true;
  return true;
}

void StackUnit::count_move(const StackSpill::Lane& lane, const StackSpill::Move& move) {
  counters_.moved_out += move.spills;
  counters_.moved_in += move.fill ? 1 : 0;
  counters_.max_spilled = std::max<std::uint64_t>(counters_.max_spilled, lane.in_memory);
}

bool StackUnit::send(Cycle now, LaneId id) {
  LaneContext& lane = lanes_[id];
  MemoryRequest message;
  message.tag = id;
  message.region = Region::stack;
  message.write = lane.to_spill > 0;
  message.address = map_.stack_sector(lane.ray, lane.next++);
  requests_.push(now, message);
  ++outstanding_;
  if (!message.write) {
    ++counters_.fills;
    queue_.pop();
    return false;  // waits for the response
  }
  ++counters_.spills;
  if (--lane.to_spill > 0) return false;
  queue_.pop();
  return true;
}

void StackUnit::issue(Cycle now) {
  if (queue_.empty() || !requests_.can_push(now)) return;
  const LaneId id = queue_.front();
  const bool settled = send(now, id);
  awake_ = !queue_.empty();
  if (settled) client_->stack_settled(id);
}

void StackUnit::respond(Cycle now) {
  const MemoryResponse* arrived = responses_.front(now);
  if (arrived == nullptr) return;
  const bool write = arrived->write;
  const auto id = static_cast<LaneId>(arrived->tag);
  responses_.pop(now);
  assert(outstanding_ > 0);
  --outstanding_;
  if (write) {
    ++counters_.acknowledged;
    return;
  }
  ++counters_.returned;
  client_->stack_settled(id);
}

Inventory StackUnit::inventory() const {
  Inventory inventory{name(), {}, {}};
  inventory.storage.push_back({"queue", StorageKind::ram, stacks_ * 8});
  inventory.storage.push_back({"offsets", StorageKind::ram, stacks_ * 8});  // entries in memory
  inventory.operators.push_back({"int_add", 64, 2});                        // base + slot offset + entry offset
  inventory.operators.push_back(
      {"int_compare", 8, std::min<std::uint64_t>(stacks_, kMaxLanes)});  // depth against the entries on chip
  return inventory;
}

void StackUnit::dump_state(std::ostream& out) const {
  out << name() << ": " << queue_.size() << " lanes to spill or fill, " << outstanding_ << " requests outstanding\n";
}

PartInfo stack_unit_info() {
  PartInfo part;
  part.name = "stack_unit";
  part.title = "stack unit";
  part.statistics = {"gpu.rt.stack."};
  part.stalls = {{"stack", "stack entries"}};
  return part;
}

}  // namespace grtx::modules
