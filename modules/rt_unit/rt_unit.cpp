// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/rt_unit.h"

#include <algorithm>
#include <ostream>

#include "grtx/base/error.h"
#include "grtx/modules/kernel/factory.h"
#include "grtx/modules/kernel/make_anew.h"
#include "grtx/modules/kernel/unit_fault.h"
#include "grtx/modules/rt_unit/any_hit_collector/any_hit_collector.h"
#include "grtx/modules/rt_unit/any_hit_unit/any_hit_unit.h"
#include "grtx/modules/rt_unit/checkpoint/checkpoint_unit.h"
#include "grtx/modules/rt_unit/delayed_hits/delayed_hits.h"
#include "grtx/modules/rt_unit/intersection/intersection_unit.h"
#include "grtx/modules/rt_unit/memory_scheduler/memory_scheduler.h"
#include "grtx/modules/rt_unit/prefetcher/sibling_prefetcher.h"
#include "grtx/modules/rt_unit/scheduler/rt_scheduler.h"
#include "grtx/modules/rt_unit/stack/stack_unit.h"
#include "grtx/modules/rt_unit/warp_buffer/warp_buffer.h"
#include "grtx/modules/rt_unit/warp_walk/warp_walk_scheduler.h"

namespace grtx::modules {

using traces::NodeKind;

namespace {

template <typename Part, typename Make>
std::unique_ptr<Part> made(const RtUnitParts::Factory<Part>& factory, const char* name, const RtUnitContext& rt,
                           const Make& make_own) {
  return factory ? not_null(factory(name, rt), name) : make_own(name);
}

}  // namespace

void RtUnitConfig::parameters(ParameterList& list) {
  list.add("traversal", traversal,
           "whether each lane has a stack, or a warp one for all, with several of its entries under way "
           "(warp_walk.md)",
           kOurs);
  list.rule(
      "traversal", [this] { return !walks() || warp_buffer.spill; }, "warp needs rt.warp_buffer.spill");
  list.rule(
      "traversal",
      [this] {
        return !walks() ||
               (box_implementation == UnitImplementation::tlm && transform_implementation == UnitImplementation::tlm);
      },
      "warp needs units of implementation tlm: those in SystemVerilog number lanes, not tests");
  list.part("warp_stack", warp_stack);
  list.part("warp_buffer", warp_buffer);
  list.part("scheduler", scheduler);
  list.part("memory", memory);
  list.part("any_hit", any_hit);
  list.part("any_hit_unit", any_hit_unit);
  list.part("checkpoint", checkpoint);
  list.under("prefetch", [&](ParameterList& prefetch) {
    prefetch.add("enabled", sibling_prefetch, "sibling prefetcher", from_paper("GRTX, Section V"));
    prefetcher.parameters(prefetch);
  });
  const Origin as_triangle = assumed("this project: as the ray-triangle unit");
  list.under("box", [&](ParameterList& box) {
    box.add("per_child", box_op_per_child, "a box operation tests one child instead of a whole node",
            from_public("UBC 2024 and Arches test a whole node, Vortex one child"));
    ray_box.parameters(box, "ray-box", kTreeTraversal);
    box.add("implementation", box_implementation, kUnitImplementations, kOurs);
  });
  list.under("triangle", [&](ParameterList& unit) { ray_triangle.parameters(unit, "ray-triangle", kTreeTraversal); });
  list.under("sphere", [&](ParameterList& unit) { ray_sphere.parameters(unit, "ray-sphere", as_triangle); });
  list.under("gaussian", [&](ParameterList& unit) {
    const Origin gautracer = from_public("GauTracer, ISCA 2026: latency 27; the number is that of our other units");
    unit.add("enabled", gaussian_unit, "procedural leaves are tested by ray-Gaussian instead of ray-sphere units",
             gautracer);
    ray_gaussian.parameters(unit, "ray-Gaussian", gautracer);
  });
  list.under("transform", [&](ParameterList& unit) {
    ray_transform.parameters(unit, "ray-transform",
                             assumed("UBC 2024 has 4; our operators need 6 at least (grtx cost)"));
    unit.add("decode_latency", leaf_decode_latency, {0, kMaxLatency}, "cycles",
             "a leaf of layout quantised is decoded before its transform",
             assumed("this project: shifter, adder and one addition, in a cycle"));
    unit.add("implementation", transform_implementation, kUnitImplementations, kOurs);
  });
}

std::vector<RtL1Client> RtUnitConfig::l1_clients(const traces::Header& header) const {
  std::vector<RtL1Client> clients;
  if (!memory.by_shader) clients.push_back({"rt_node", memory.sectors_per_cycle, true});
  if (header.checkpoint) clients.push_back({"rt_checkpoint"});
  if (has_prefetcher(header)) clients.push_back({"rt_prefetch"});
  if (warp_buffer.spill) clients.push_back({"rt_stack"});
  return clients;
}

RtUnit::RtUnit(const sc_core::sc_module_name& name, const RtUnitConfig& config, const traces::Header& header,
               const MemoryMap& map, ClockDomain& domain, unsigned sm, const RtUnitParts& parts)
    : RtUnitModule(name, domain),
      config_(config),
      traffic_(header, config.memory.traffic),
      context_{config_, header, map, traffic_, sm},
      dispatch_("node_dispatch", {config.box_op_per_child, transforms_leaves(header), traffic_.leaf_tests(),
                                  traces::has_box_leaves(header.accel)}) {
  if (header.warp_size > kMaxLanes) throw Error("trace", "header", "warp_size must be at most 32");
  build(parts, header);
  list_parts();
  bind_parts();
}

// Only the parts that this trace and this configuration need exist.
void RtUnit::build(const RtUnitParts& parts, const traces::Header& header) {
  const unsigned entries = config_.warp_buffer.entries;
  const bool bounded = header.opacity_bound == traces::OpacityBound::on;
  StackEntryLayout stack_entry = stack_entry_layout(header.pop_test);
  if (config_.walks()) stack_entry.bits = 0;  // the stack of a warp is in the warp walk scheduler
  warp_buffer_ = made(parts.warp_buffer, "warp_buffer", context_, [&](const char* name) {
    return std::make_unique<WarpBuffer>(name, config_.warp_buffer, header.checkpoint, stack_entry, header.three_level(),
                                        header.bvh_width, header.two_level ? 3 : 2);
  });
  memory_ = made(parts.memory_scheduler, "memory_scheduler", context_, [&](const char* name) {
    return std::make_unique<MemoryScheduler>(name, config_.memory, header, entries, !config_.walks());
  });
  if (config_.any_hit_unit.enabled) {
    any_hit_ = made(parts.any_hit_unit, "any_hit_unit", context_, [&](const char* name) {
      return std::make_unique<AnyHitUnit>(name, config_.any_hit_unit, entries, header.k, header.checkpoint, bounded);
    });
  } else if (header.any_hit == traces::AnyHit::delayed) {
    any_hit_ = made(parts.delayed_hits, "delayed_hits", context_,
                    [&](const char* name) { return std::make_unique<DelayedHits>(name, entries); });
  } else {
    any_hit_ = made(parts.any_hit_collector, "any_hit_collector", context_, [&](const char* name) {
      return std::make_unique<AnyHitCollector>(name, config_.any_hit, entries, bounded && header.two_level);
    });
  }
  if (header.checkpoint) {
    checkpoint_ = made(parts.checkpoint_unit, "checkpoint_unit", context_, [&](const char* name) {
      return std::make_unique<CheckpointUnit>(name, config_.checkpoint, context_.map, header, entries, context_.sm);
    });
  }
  if (config_.has_prefetcher(header)) {
    const SiblingPrefetcher::Triggers triggers{config_.sibling_prefetch, config_.names_siblings_in_entries(header)};
    prefetcher_ = made(parts.sibling_prefetcher, "sibling_prefetcher", context_, [&](const char* name) {
      return std::make_unique<SiblingPrefetcher>(name, config_.prefetcher, triggers, traffic_, entries);
    });
  }
  if (config_.warp_buffer.spill) {
    stack_ = made(parts.stack_unit, "stack_unit", context_, [&](const char* name) {
      if (config_.walks()) {
        return std::make_unique<StackUnit>(name, config_.warp_stack.entries, warp_stack_entry_layout(header.pop_test),
                                           context_.map, entries, context_.sm, 1u);
      }
      return std::make_unique<StackUnit>(name, config_.warp_buffer.stack_entries, stack_entry, context_.map, entries,
                                         context_.sm);
    });
  }
  build_scheduler(parts, header);
  build_units(parts, header);
}

void RtUnit::build_scheduler(const RtUnitParts& parts, const traces::Header& header) {
  const unsigned entries = config_.warp_buffer.entries;
  if (config_.walks()) {
    require_walkable(header);
    scheduler_ = made(parts.warp_walk_scheduler, "warp_walk_scheduler", context_, [&](const char* name) {
      return std::make_unique<WarpWalkScheduler>(name, config_.warp_stack, config_.scheduler, entries, header,
                                                 config_.memory.node_ports);
    });
    return;
  }
  scheduler_ = made(parts.rt_scheduler, "rt_scheduler", context_, [&](const char* name) {
    return std::make_unique<RtScheduler>(name, config_.scheduler, entries, traces::has_box_leaves(header.accel));
  });
}

void RtUnit::build_units(const RtUnitParts& parts, const traces::Header& header) {
  const unsigned entries = config_.warp_buffer.entries;
  const bool behind = transforms_leaves(header);  // the transform unit passes ray and Gaussian on
  const auto unit = [&](const RtUnitParts::Factory<IntersectionModule>& factory, const char* of,
                        const IntersectionUnit::Config& config, const DataPath& path, bool reads = true) {
    return made(factory, of, context_, [&](const char* name) {
      return std::make_unique<IntersectionUnit>(name, config, entries, path, config_.test_input(reads));
    });
  };
  ray_box_ = unit(parts.ray_box, "ray_box", config_.ray_box, config_.box_path(header));
  if (traffic_.leaf_kind() == NodeKind::triangle) {
    ray_triangle_ = unit(parts.ray_triangle, "ray_triangle", config_.ray_triangle, ray_triangle_path());
  } else if (config_.tests_gaussians(header)) {
    ray_gaussian_ =
        unit(parts.ray_gaussian, "ray_gaussian", config_.ray_gaussian,
             ray_gaussian_path(header.inputs.contains("sort_key") && header.inputs.at("sort_key") == "entry"), !behind);
  } else if (!traces::has_box_leaves(header.accel)) {
    ray_sphere_ = unit(parts.ray_sphere, "ray_sphere", config_.ray_sphere, ray_sphere_path(), !behind);
  }
  if (header.two_level || behind) {
    ray_transform_ = unit(parts.ray_transform, "ray_transform", config_.transform_unit(header),
                          RtUnitConfig::transform_path(header));
  }
}

void RtUnit::list_parts() {
  parts_ = {warp_buffer_.get(), scheduler_.get(), memory_.get(), any_hit_.get(), &dispatch_};
  for (const auto* unit : {&ray_box_, &ray_triangle_, &ray_sphere_, &ray_gaussian_, &ray_transform_}) {
    if (*unit != nullptr) units_.push_back(unit->get());
  }
  parts_.insert(parts_.end(), units_.begin(), units_.end());
  if (checkpoint_) parts_.push_back(checkpoint_.get());
  if (prefetcher_) parts_.push_back(prefetcher_.get());
  if (stack_) parts_.push_back(stack_.get());
}

void RtUnit::bind_parts() {
  warp_buffer_->trace_call.bind(trace_call);
  warp_buffer_->trace_done.bind(trace_done);
  warp_buffer_->admission.bind(*scheduler_);

  scheduler_->warp_buffer.bind(*warp_buffer_);
  scheduler_->node_fetch.bind(*memory_);
  scheduler_->any_hit.bind(*any_hit_);

  memory_->warp_buffer.bind(*warp_buffer_);
  if (fetched_node_if* const walker = scheduler_->fetched_nodes()) {
    memory_->fetched_node.bind(*walker);
    scheduler_->node_test.bind(dispatch_);
  } else {
    memory_->fetched_node.bind(dispatch_);
  }
  if (fetches_nodes()) {
    memory_->request.bind(node_request);
    memory_->response.bind(node_response);
    if (config_.memory.asks_at_once()) memory_->l1_reads.bind(node_reads);
  } else {
    memory_->batch.bind(node_fetch);
    memory_->batch_done.bind(node_fetch_done);
  }

  any_hit_->warp_buffer.bind(*warp_buffer_);
  any_hit_->client.bind(*scheduler_);
  any_hit_->batch.bind(any_hit_batch);
  any_hit_->done.bind(any_hit_done);

  bind_dispatch();
  bind_optional_parts();
}

void RtUnit::bind_dispatch() {
  dispatch_.warp_buffer.bind(*warp_buffer_);
  dispatch_.client.bind(*scheduler_);
  dispatch_.ray_box.bind(*ray_box_);
  if (ray_triangle_) dispatch_.ray_triangle.bind(*ray_triangle_);
  if (ray_sphere_) dispatch_.ray_sphere.bind(*ray_sphere_);
  if (ray_gaussian_) dispatch_.ray_gaussian.bind(*ray_gaussian_);
  if (ray_transform_) dispatch_.ray_transform.bind(*ray_transform_);
  for (IntersectionModule* unit : units_) {
    if (unit == ray_transform_.get() && dispatch_.transforms_leaves()) {
      unit->client.bind(dispatch_);
    } else {
      unit->client.bind(*scheduler_);
    }
  }
}

// Parts that exist only for some traces and configurations.
void RtUnit::bind_optional_parts() {
  if (checkpoint_) {
    scheduler_->checkpoint.bind(*checkpoint_);
    checkpoint_->client.bind(*scheduler_);
    checkpoint_->request.bind(checkpoint_request);
    checkpoint_->response.bind(checkpoint_response);
  }
  if (prefetcher_) {
    scheduler_->prefetch.bind(*prefetcher_);
    prefetcher_->request.bind(prefetch_request);
    prefetcher_->response.bind(prefetch_response);
  }
  if (stack_) {
    scheduler_->stack.bind(*stack_);
    stack_->client.bind(*scheduler_);
    stack_->request.bind(stack_request);
    stack_->response.bind(stack_response);
  }
}

void RtUnit::end_of_elaboration() {
  warps_ = &warp_buffer_->warps();
  calls_ = reader_of(trace_call);
  shader_dones_ = reader_of(any_hit_done);
  fetches_done_ = reader_of(node_fetch_done);
  calls_.wake(&alarm_);
  shader_dones_.wake(&alarm_);
  if (fetches_done_) fetches_done_.wake(&alarm_);
  waiting_.watch(kAnyHit, shader_dones_);
  waiting_.watch(kCalls, calls_);
  any_hit_->show_awake(awake_, kAnyHit);
  add_client(kMemory, memory_.get(), reader_of(node_response));
  add_client(kCheckpoint, checkpoint_.get(), reader_of(checkpoint_response));
  add_client(kPrefetch, prefetcher_.get(), reader_of(prefetch_response));
  add_client(kStack, stack_.get(), reader_of(stack_response));
}

void RtUnit::add_client(unsigned place, RtMemoryPart* part, const LinkReader<MemoryResponse>& responses) {
  if (part == nullptr) return;
  clients_[place] = {part, responses};
  part->show_awake(awake_, place);
  if (!responses) return waiting_.always(place);
  responses.wake(&alarm_);
  waiting_.watch(place, responses);
}

void RtUnit::restart(Caches) {
  make_anew(traffic_, context_.header, config_.memory.traffic);  // before the parts that refer to it
  for (RtPart* part : parts_) part->restart();
  due_ = kNever;
  accounted_ = settled_ = 0;
}

// First cycle in which an item on this input link is visible and can be taken.
inline Cycle RtUnit::arrival(unsigned link) const {
  if (link == kCalls) return warps_->has_room() ? calls_.next_visible() : kNever;
  if (link == kAnyHit) return shader_dones_.next_visible();
  const LinkReader<MemoryResponse>& responses = clients_[link].responses;
  if (responses) return responses.next_visible();
  return link == kMemory && fetches_done_ ? fetches_done_.next_visible() : kNever;
}

Cycle RtUnit::next_arrival() const {
  Cycle next = kNever;
  waiting_.for_each([&](unsigned link) { next = std::min(next, arrival(link)); });
  return next;
}

Cycle RtUnit::tick(Cycle now) {
  if (now < due_) {
    if (const Cycle next = std::min(due_, next_arrival()); now < next) return next;
  }
  // Nothing changed in the skipped cycles, so all of them have the stall reason of the current state.
  if (now > accounted_) scheduler_->count_idle(now - accounted_);
  accounted_ = now + 1;
  warps_->account(now + 1);
  run_stages(now);
  due_ = next_due(now);
  return due_ == now + 1 ? due_ : std::min(due_, std::max(next_arrival(), now + 1));
}

inline void RtUnit::tick_units(Cycle now) {
  IntersectionModule* ticking = nullptr;
  try {
    for (IntersectionModule* unit : units_) {
      ticking = unit;
      if (unit->due() <= now) unit->tick(now);
    }
  } catch (const WrongAnswer& answer) {
    unit_fault(ticking->name(), answer.what());
  }
}

// Reverse pipeline order: the output of a stage for a stage earlier in this list is used in the next cycle; a result
// that makes a lane ready is seen by the scheduler in the same cycle. Stages without work, according to the warp table
// or a link, are not called.
inline void RtUnit::run_stages(Cycle now) {
  tick_units(now);
  bool shaders_done = false, called = false;
  waiting_.for_each([&](unsigned link) {
    if (link >= kClients) {
      (link == kCalls ? called : shaders_done) = true;
      return;
    }
    const MemoryClient& client = clients_[link];
    if (!client.responses) return client.part->respond(now);
    if (client.responses.next_visible() > now) return;
    client.part->respond(now);
    waiting_.popped(link, client.responses);
  });
  for (unsigned place = 0; place < kClients; ++place) {
    if (is_awake(place)) clients_[place].part->issue(now);
  }
  if (is_awake(kCheckpoint)) checkpoint_->accept(now);
  if (is_awake(kAnyHit) || (shaders_done && shader_dones_.next_visible() <= now)) {
    any_hit_->invoke(now);
    if (shaders_done) waiting_.popped(kAnyHit, shader_dones_);
  }
  if (warps_->finished_entries() != 0) warp_buffer_->retire(now);
  if (scheduler_->working()) scheduler_->prepare(now);
  if (warps_->ready_entries() != 0) {
    scheduler_->schedule(now);
  } else {
    scheduler_->count_idle(1);
  }
  if (called && calls_.next_visible() <= now) {
    warp_buffer_->accept(now);
    waiting_.popped(kCalls, calls_);
  }
}

inline Cycle RtUnit::next_due(Cycle now) const {
  if (warps_->ready_entries() != 0 || warps_->finished_entries() != 0 || scheduler_->working()) return now + 1;
  for (unsigned place = 0; place < kClients; ++place) {
    if (is_awake(place) && clients_[place].part->busy()) return now + 1;
  }
  Cycle due = is_awake(kAnyHit) ? any_hit_->next_due(now) : kNever;
  for (const IntersectionModule* unit : units_) due = std::min(due, unit->due());
  return std::max(due, now + 1);
}

bool RtUnit::idle() const {
  return std::all_of(parts_.begin(), parts_.end(), [](const RtPart* part) { return part->idle(); });
}

std::uint64_t RtUnit::progress() const {
  std::uint64_t sum = 0;
  for_each_part([&](const RtPart& part) { sum += part.progress(); });
  return sum;
}

void RtUnit::settle(Cycle end) {
  if (end > accounted_) {
    scheduler_->count_idle(end - accounted_);
    accounted_ = end;
  }
  warp_buffer_->settle(end);
  settled_ = end;
}

RtUnitCounters RtUnit::counters() const {
  RtUnitCounters c;
  c.units = 1;
  const auto take = [](auto& counters, const auto& part) {
    if (part != nullptr) counters = part->counters();
  };
  take(c.warp_buffer, warp_buffer_);
  take(c.scheduler, scheduler_);
  take(c.memory, memory_);
  take(c.ray_box, ray_box_);
  take(c.ray_triangle, ray_triangle_);
  take(c.ray_sphere, ray_sphere_);
  take(c.ray_gaussian, ray_gaussian_);
  take(c.ray_transform, ray_transform_);
  take(c.any_hit, any_hit_);
  take(c.checkpoint, checkpoint_);
  take(c.prefetch, prefetcher_);
  take(c.stack, stack_);
  for_each_part([&](const RtPart& part) { part.count(c.own); });
  return c;
}

void RtUnit::statistics(StatisticList& list, const std::string& prefix) const {
  counters().describe(list, prefix, settled_);
}

std::vector<Inventory> RtUnit::inventory() const {
  std::vector<Inventory> all;
  for_each_part([&](const RtPart& part) { all.push_back(part.inventory()); });
  return all;
}

void RtUnit::dump_state(std::ostream& out) const {
  out << name() << ": cycle " << clock_.cycle() << ", next due "
      << (due_ == kNever ? std::string("never") : std::to_string(due_)) << '\n';
  for_each_part([&](const RtPart& part) { part.dump_state(out); });
}

std::unique_ptr<RtUnitModule> make_rt_unit(const sc_core::sc_module_name& name, const RtUnitConfig& config,
                                           const traces::Header& header, const MemoryMap& map, ClockDomain& domain,
                                           unsigned sm, const RtUnitParts& parts) {
  return std::make_unique<RtUnit>(name, config, header, map, domain, sm, parts);
}

}  // namespace grtx::modules
