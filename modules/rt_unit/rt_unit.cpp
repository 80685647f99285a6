#include "grtx/modules/rt_unit/rt_unit.h"

#include <algorithm>
#include <ostream>

#include "grtx/base/error.h"

namespace grtx::sim {

using namespace modules;
using traces::NodeKind;

void RtUnitCounters::add(const RtUnitCounters& other) {
  units += other.units;
  warp_buffer.add(other.warp_buffer);
  scheduler.add(other.scheduler);
  memory.add(other.memory);
  ray_box.add(other.ray_box);
  ray_triangle.add(other.ray_triangle);
  ray_sphere.add(other.ray_sphere);
  ray_transform.add(other.ray_transform);
  any_hit.add(other.any_hit);
  checkpoint.add(other.checkpoint);
  prefetch.add(other.prefetch);
  stack.add(other.stack);
}

void RtUnitCounters::describe(StatisticList& list, const std::string& prefix, Cycle cycles) const {
  memory.describe(list, prefix);
  scheduler.describe(list, prefix);
  warp_buffer.describe(list, prefix);
  const double unit_cycles = static_cast<double>(units) * static_cast<double>(cycles);
  list.add(prefix + ".occupancy",
           unit_cycles > 0.0 ? static_cast<double>(warp_buffer.occupancy_integral) / unit_cycles : 0.0, "warps",
           "mean warps in the warp buffer of an RT unit");
  ray_box.describe(list, prefix + ".ray_box");
  ray_triangle.describe(list, prefix + ".ray_triangle");
  ray_sphere.describe(list, prefix + ".ray_sphere");
  ray_transform.describe(list, prefix + ".ray_transform");
  any_hit.describe(list, prefix + ".any_hit");
  checkpoint.describe(list, prefix + ".checkpoint");
  prefetch.describe(list, prefix + ".prefetch");
  stack.describe(list, prefix + ".stack");
}

RtUnit::RtUnit(const sc_core::sc_module_name& name, const RtUnitConfig& config, const traces::Header& header,
               const MemoryMap& map, ClockDomain& domain, unsigned sm)
    : ClockedModule(name, domain),
      trace_call("trace_call"),
      trace_done("trace_done"),
      any_hit_batch("any_hit_batch"),
      any_hit_done("any_hit_done"),
      node_request("node_request"),
      node_response("node_response"),
      node_fetch("node_fetch"),
      node_fetch_done("node_fetch_done"),
      checkpoint_request("checkpoint_request"),
      checkpoint_response("checkpoint_response"),
      prefetch_request("prefetch_request"),
      prefetch_response("prefetch_response"),
      stack_request("stack_request"),
      stack_response("stack_response"),
      config_(config),
      warp_buffer_("warp_buffer", config.warp_buffer, header.checkpoint),
      memory_("memory_scheduler", config.memory, header, config.warp_buffer.entries),
      any_hit_("any_hit_collector", config.any_hit, warp_buffer_),
      checkpoint_(header.checkpoint ? std::make_unique<CheckpointUnit>(
                                          "checkpoint_unit", config.checkpoint, map, header.checkpoint_order,
                                          header.checkpoint_capacity, config.warp_buffer.entries, sm)
                                    : nullptr),
      prefetcher_(config.sibling_prefetch
                      ? std::make_unique<SiblingPrefetcher>("sibling_prefetcher", config.prefetcher, memory_.traffic(),
                                                            config.warp_buffer.entries)
                      : nullptr),
      stack_(config.warp_buffer.spill ? std::make_unique<StackUnit>("stack_unit", config.warp_buffer.stack_entries, map,
                                                                    config.warp_buffer.entries, sm)
                                      : nullptr),
      scheduler_("rt_scheduler", config.scheduler, warp_buffer_, memory_, any_hit_, checkpoint_.get(),
                 prefetcher_.get(), stack_.get()) {
  if (header.warp_size > kMaxLanes) throw Error("trace", "header", "warp_size must be at most 32");
  // Only the units that this structure needs exist.
  const unsigned entries = config.warp_buffer.entries;
  const unsigned boxes = config.box_op_per_child ? 1 : header.bvh_width;
  ray_box_ = std::make_unique<IntersectionUnit>("ray_box", config.ray_box, entries, ray_box_path(boxes));
  if (memory_.traffic().leaf_kind() == NodeKind::triangle) {
    ray_triangle_ =
        std::make_unique<IntersectionUnit>("ray_triangle", config.ray_triangle, entries, ray_triangle_path());
  } else {
    ray_sphere_ = std::make_unique<IntersectionUnit>("ray_sphere", config.ray_sphere, entries, ray_sphere_path());
  }
  if (header.two_level) {
    ray_transform_ =
        std::make_unique<IntersectionUnit>("ray_transform", config.ray_transform, entries, ray_transform_path());
  }
  for (const auto* unit : {&ray_box_, &ray_triangle_, &ray_sphere_, &ray_transform_}) {
    if (*unit != nullptr) units_.push_back(unit->get());
  }
}

void RtUnit::end_of_elaboration() {
  calls_ = reader_of(trace_call);
  dones_ = writer_of(trace_done);
  batches_ = writer_of(any_hit_batch);
  shader_dones_ = reader_of(any_hit_done);
  calls_.wake(&alarm_);
  shader_dones_.wake(&alarm_);
  if (fetches_nodes()) {
    node_requests_ = writer_of(node_request);
    node_responses_ = reader_of(node_response);
    node_responses_.wake(&alarm_);
  } else {
    fetch_batches_ = writer_of(node_fetch);
    fetches_done_ = reader_of(node_fetch_done);
    fetches_done_.wake(&alarm_);
  }
  if (checkpoint_) {
    checkpoint_requests_ = writer_of(checkpoint_request);
    checkpoint_responses_ = reader_of(checkpoint_response);
    checkpoint_responses_.wake(&alarm_);
  }
  if (prefetcher_) {
    prefetch_requests_ = writer_of(prefetch_request);
    prefetch_responses_ = reader_of(prefetch_response);
    prefetch_responses_.wake(&alarm_);
  }
  if (stack_) {
    stack_requests_ = writer_of(stack_request);
    stack_responses_ = reader_of(stack_response);
    stack_responses_.wake(&alarm_);
  }
}

// First cycle in which a link shows something to this unit.
Cycle RtUnit::next_arrival() const {
  const Cycle fetched = fetches_nodes() ? node_responses_.next_visible() : fetches_done_.next_visible();
  Cycle next = std::min(fetched, shader_dones_.next_visible());
  if (checkpoint_) next = std::min(next, checkpoint_responses_.next_visible());
  if (prefetcher_) next = std::min(next, prefetch_responses_.next_visible());
  if (stack_) next = std::min(next, stack_responses_.next_visible());
  if (warp_buffer_.has_room()) next = std::min(next, calls_.next_visible());
  return next;
}

Cycle RtUnit::tick(Cycle now) {
  if (const Cycle next = std::min(due_, next_arrival()); now < next) return next;
  // Nothing changed in the cycles between: they all had the reason of the present state.
  if (now > accounted_) scheduler_.count_idle(now - accounted_);
  accounted_ = now + 1;
  warp_buffer_.account(now + 1);
  run_stages(now);
  due_ = next_due(now);
  return std::min(due_, std::max(next_arrival(), now + 1));
}

// Reverse pipeline order: what a stage hands to the one before it in this list is used in the next cycle; results that
// make a lane ready are seen by the scheduler in the same cycle.
void RtUnit::run_stages(Cycle now) {
  for_each_unit([&](IntersectionUnit& unit) {
    if (unit.due() <= now) unit.collect(now, [&](LaneId id) { scheduler_.unit_result(now, id); });
  });
  for_each_unit([&](IntersectionUnit& unit) {
    if (unit.due() <= now) unit.start(now);
  });
  take_responses(now);
  issue_requests(now);
  if (checkpoint_) checkpoint_->accept([&](LaneId id) { scheduler_.entries_taken(id); });
  invoke_any_hit(now);
  retire(now);
  scheduler_.schedule(now);
  accept(now);
}

IntersectionUnit& RtUnit::unit_of(NodeKind kind) {
  switch (kind) {
    case NodeKind::internal:
      return *ray_box_;
    case NodeKind::instance:
      return *ray_transform_;
    case NodeKind::procedural:
      return *ray_sphere_;
    case NodeKind::triangle:
      return *ray_triangle_;
  }
  throw Error("RT unit", "node", "has an unknown kind");
}

void RtUnit::take_fetch(Cycle now, const MemoryScheduler::Completed& fetch) {
  warp_buffer_.move(fetch.entry, fetch.lanes, LaneState::waiting_memory, LaneState::in_unit);
  IntersectionUnit& unit = unit_of(fetch.kind);
  const Warp& warp = warp_buffer_.warp(fetch.entry);
  for_each_bit(fetch.lanes, [&](unsigned i) {
    const Lane& lane = warp.lane[i];
    prefetch_for_read(lane.next + 2);  // needed after the test
    if (prefetcher_ && fetch.kind == NodeKind::internal) prefetch_for_read(&warp.group->nodes[lane.event.node]);
    unsigned tests = 1;
    if (config_.box_op_per_child && fetch.kind == NodeKind::internal) {
      tests = std::max(1u, unsigned{warp.group->nodes[lane.event.node].child_count});
    }
    unit.enqueue(now, lane_id(fetch.entry, i), tests);
  });
}

void RtUnit::take_responses(Cycle now) {
  if (fetches_nodes()) {
    const MemoryScheduler::Completed fetch = memory_.respond(now, node_responses_);
    if (fetch.lanes != 0) take_fetch(now, fetch);
  } else {
    memory_.respond_batch(now, fetches_done_, [&](const MemoryScheduler::Completed& fetch) { take_fetch(now, fetch); });
  }
  if (checkpoint_) {
    if (const auto lane = checkpoint_->respond(now, checkpoint_responses_)) scheduler_.entry_read(*lane);
  }
  if (prefetcher_) prefetcher_->respond(now, prefetch_responses_);
  if (stack_) {
    if (const auto lane = stack_->respond(now, stack_responses_)) scheduler_.stack_settled(*lane);
  }
}

void RtUnit::issue_requests(Cycle now) {
  if (fetches_nodes()) {
    memory_.issue(now, node_requests_);
  } else {
    memory_.issue_batch(now, fetch_batches_, [&](unsigned e) { return warp_buffer_.warp(e).slot; });
  }
  if (checkpoint_) checkpoint_->issue(now, checkpoint_requests_);
  if (prefetcher_) prefetcher_->issue(now, prefetch_requests_);
  if (stack_) stack_->issue(now, stack_requests_, [&](LaneId id) { scheduler_.stack_settled(id); });
}

void RtUnit::invoke_any_hit(Cycle now) {
  if (const AnyHitDone* done = shader_dones_.front(now)) {
    scheduler_.any_hit_done(*done);
    shader_dones_.pop(now);
  }
  any_hit_.fire(now, batches_);
}

void RtUnit::retire(Cycle now) {
  const LaneMask finished = warp_buffer_.finished_entries();
  if (finished == 0 || !dones_.can_push(now)) return;
  const unsigned entry = warp_buffer_.oldest(finished);
  const Warp& warp = warp_buffer_.warp(entry);
  dones_.push(now, {warp.slot, warp.round});
  warp_buffer_.release(now, entry);
}

void RtUnit::accept(Cycle now) {
  if (!warp_buffer_.has_room()) return;
  const TraceCall* call = calls_.front(now);
  if (call == nullptr) return;
  const unsigned entry = warp_buffer_.accept(now, *call);
  calls_.pop(now);
  scheduler_.begin(entry);
}

Cycle RtUnit::next_due(Cycle now) const {
  if (warp_buffer_.ready_entries() != 0 || warp_buffer_.finished_entries() != 0 || !memory_.queue_empty() ||
      (checkpoint_ && checkpoint_->busy()) || (prefetcher_ && prefetcher_->busy()) || (stack_ && stack_->busy())) {
    return now + 1;
  }
  Cycle due = any_hit_.next_due(now);
  for_each_unit([&](const IntersectionUnit& unit) { due = std::min(due, unit.due()); });
  due = std::max(due, now + 1);
  return due;
}

bool RtUnit::idle() const {
  bool idle = warp_buffer_.empty() && memory_.idle() && (!checkpoint_ || checkpoint_->idle()) &&
              (!prefetcher_ || prefetcher_->idle()) && (!stack_ || stack_->idle());
  for_each_unit([&](const IntersectionUnit& unit) { idle = idle && unit.idle(); });
  return idle;
}

std::uint64_t RtUnit::progress() const {
  const auto& memory = memory_.counters();
  std::uint64_t sum = scheduler_.counters().selections + memory.node_sectors() + memory.fetch_latency.count() +
                      warp_buffer_.counters().calls + warp_buffer_.counters().warp_latency.count() +
                      any_hit_.counters().batches;
  for_each_unit([&](const IntersectionUnit& unit) { sum += unit.counters().operations; });
  if (checkpoint_) {
    const auto& c = checkpoint_->counters();
    sum += c.sectors_read + c.sectors_written + c.acknowledged + c.returned;
  }
  if (stack_) sum += stack_->counters().spills + stack_->counters().fills + stack_->counters().returned;
  return sum;
}

void RtUnit::settle(Cycle end) {
  if (end > accounted_) {
    scheduler_.count_idle(end - accounted_);
    accounted_ = end;
  }
  warp_buffer_.account(end);
  warp_buffer_.count_waits();
  warp_buffer_.settle(end);
  settled_ = end;
}

RtUnitCounters RtUnit::counters() const {
  RtUnitCounters c;
  c.units = 1;
  c.warp_buffer = warp_buffer_.counters();
  c.scheduler = scheduler_.counters();
  c.memory = memory_.counters();
  c.ray_box = ray_box_->counters();
  if (ray_triangle_) c.ray_triangle = ray_triangle_->counters();
  if (ray_sphere_) c.ray_sphere = ray_sphere_->counters();
  if (ray_transform_) c.ray_transform = ray_transform_->counters();
  c.any_hit = any_hit_.counters();
  if (checkpoint_) c.checkpoint = checkpoint_->counters();
  if (prefetcher_) c.prefetch = prefetcher_->counters();
  if (stack_) c.stack = stack_->counters();
  return c;
}

void RtUnit::statistics(StatisticList& list, const std::string& prefix) const {
  counters().describe(list, prefix, settled_);
}

std::vector<Inventory> RtUnit::inventory() const {
  std::vector<Inventory> all = {warp_buffer_.inventory(), scheduler_.inventory(), memory_.inventory(),
                                any_hit_.inventory()};
  for_each_unit([&](const IntersectionUnit& unit) { all.push_back(unit.inventory()); });
  if (checkpoint_) all.push_back(checkpoint_->inventory());
  if (prefetcher_) all.push_back(prefetcher_->inventory());
  if (stack_) all.push_back(stack_->inventory());
  return all;
}

void RtUnit::dump_state(std::ostream& out) const {
  out << name() << ": cycle " << clock_.cycle() << ", next due "
      << (due_ == kNever ? std::string("never") : std::to_string(due_)) << '\n';
  warp_buffer_.dump_state(out);
  memory_.dump_state(out);
  for_each_unit([&](const IntersectionUnit& unit) { unit.dump_state(out); });
  any_hit_.dump_state(out);
  if (checkpoint_) checkpoint_->dump_state(out);
  if (prefetcher_) prefetcher_->dump_state(out);
  if (stack_) stack_->dump_state(out);
}

}  // namespace grtx::sim
