// SPDX-License-Identifier: Apache-2.0
// check() catches each rule that a trace can break: one mutation of a sound trace for each.
#include "grtx/traces/check.h"
#include "grtx/traces/reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>

#include "grtx/base/error.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::traces {
namespace {

using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using testing::RandomOptions;
using testing::RandomTrace;

RandomTrace replaying() { return testing::random_trace({.seed = 5, .groups = 6, .k = 3, .two_level = true}); }
/// Three levels: every seed's rays replay nodes of the scene TLAS, of objects and of the BLAS.
RandomTrace placed() {
  return testing::random_trace({.seed = 5, .groups = 12, .k = 3, .two_level = true, .objects = 2});
}
bool in_scene(const Header& header, std::uint32_t address) {
  return address * header.node_sizes().unit() < header.objects_base();
}
RandomTrace overflowing() {
  return testing::random_trace({.seed = 6, .groups = 12, .bvh_width = 8, .depth = 4, .k = 2, .capacity = 6});
}
RandomTrace restarting() { return testing::random_trace({.seed = 7, .groups = 6, .k = 3, .checkpoint = false}); }

/// Whose stack entries hold no t.
RandomTrace stale_nodes() {
  return testing::random_trace({.seed = 7, .groups = 6, .k = 3, .checkpoint = false, .pop_test = PopTest::off});
}

/// Whose children are popped in Vulkan-Sim's order.
RandomTrace wide() {
  return testing::random_trace({.seed = 7,
                                .groups = 6,
                                .layout = NodeLayout::quantised,
                                .procedural = true,
                                .k = 3,
                                .checkpoint = false,
                                .wide = true});
}
RandomTrace wide_instances() {
  return testing::random_trace(
      {.seed = 5, .groups = 6, .layout = NodeLayout::quantised, .k = 3, .two_level = true, .wide = true});
}
RandomTrace following() {
  return testing::random_trace(
      {.seed = 9, .groups = 6, .k = 3, .checkpoint = false, .child_order = ChildOrder::vulkan_sim});
}

RandomTrace delayed() {
  return testing::random_trace({.seed = 7, .groups = 6, .k = 3, .checkpoint = false, .any_hit = AnyHit::delayed});
}
RandomTrace tested_once_a_round() {
  return testing::random_trace({.seed = 7, .groups = 6, .k = 3, .ert_check = ErtCheck::round});
}

RandomTrace single_round() {
  return testing::random_trace({.seed = 8, .groups = 6, .k = 4, .checkpoint = false, .tracing = Tracing::single});
}
RandomTrace list() {
  return testing::random_trace({.seed = 8, .groups = 6, .k = 4, .checkpoint = false, .tracing = Tracing::list});
}
RandomTrace closest_hit() {
  return testing::random_trace(
      {.seed = 9, .groups = 6, .k = 1, .checkpoint = false, .two_level = true, .tracing = Tracing::closest});
}

// Where a mutation can bite: an event with the k-buffer's state before it, or a round.
struct EventPlace {
  Header& header;
  RayGroup& group;
  Ray& ray;
  Round& round;
  Event& event;
  std::size_t index;  ///< in ray.events
  unsigned occupied;  ///< k-buffer entries before the event
  bool last_in_round;
};
struct RoundPlace {
  Header& header;
  RayGroup& group;
  Ray& ray;
  Round& round;
  std::size_t index;
  bool last;
  std::size_t first_event;
  std::size_t first_processed;
};

// Each tries the places in order until the mutation applies (returns true).
using Mutation = std::function<bool(RandomTrace&)>;

Mutation on_event(const std::function<bool(EventPlace)>& change) {
  return [change](RandomTrace& trace) {
    for (RayGroup& group : trace.groups) {
      for (Ray& ray : group.rays) {
        std::size_t next = 0;
        for (Round& round : ray.rounds) {
          unsigned occupied = round.preloaded;
          for (std::uint32_t e = 0; e < round.event_count; ++e, ++next) {
            Event& event = ray.events[next];
            const Event before = event;
            if (change({trace.header, group, ray, round, event, next, occupied, e + 1 == round.event_count}))
              return true;
            if (before.kind() == EventKind::visit_leaf && before.outcome() == LeafOutcome::inserted) ++occupied;
          }
        }
      }
    }
    return false;
  };
}

Mutation on_round(const std::function<bool(RoundPlace)>& change) {
  return [change](RandomTrace& trace) {
    for (RayGroup& group : trace.groups) {
      for (Ray& ray : group.rays) {
        std::size_t event = 0;
        std::size_t processed = 0;
        for (std::size_t r = 0; r < ray.rounds.size(); ++r) {
          Round& round = ray.rounds[r];
          const std::uint32_t events = round.event_count;
          const std::uint16_t entries = round.processed_count;
          const bool last = r + 1 == ray.rounds.size();
          if (change({trace.header, group, ray, round, r, last, event, processed})) return true;
          event += events;
          processed += entries;
        }
      }
    }
    return false;
  };
}

bool is_leaf(const Event& event, LeafOutcome outcome) {
  return event.kind() == EventKind::visit_leaf && event.outcome() == outcome;
}
void set_leaf(Event& event, LeafOutcome outcome, unsigned shifts = 0, bool checkpoint = false) {
  event.detail = static_cast<std::uint8_t>(outcome);
  event.checkpoints = checkpoint ? 1 : 0;
  event.kind_shifts = Event::pack(EventKind::visit_leaf, shifts);
}
/// The first leaf of one outcome has another.
Mutation becomes(LeafOutcome before, LeafOutcome after, unsigned shifts = 0) {
  return on_event([=](EventPlace p) { return is_leaf(p.event, before) && (set_leaf(p.event, after, shifts), true); });
}
bool drop(EventPlace p) {
  p.ray.events.erase(p.ray.events.begin() + static_cast<std::ptrdiff_t>(p.index));
  --p.round.event_count;
  return true;
}
bool repeat(EventPlace p) {
  p.ray.events.insert(p.ray.events.begin() + static_cast<std::ptrdiff_t>(p.index), Event(p.event));
  ++p.round.event_count;
  return true;
}
bool truncate_to(RoundPlace p) {
  if (p.last || p.round.terminated) return false;
  p.ray.events.resize(p.first_event + p.round.event_count);
  p.ray.processed.resize(p.first_processed + p.round.processed_count);
  p.ray.rounds.resize(p.index + 1);
  return true;
}

struct Case {
  const char* name;
  RandomTrace (*base)();
  const char* rule;
  Mutation mutate;
};

std::vector<Case> cases() {
  return {
      // Rounds
      {"FirstRoundReplays", replaying, "the first round must start at the root",
       on_round([](RoundPlace p) { return p.round.replay = p.index == 0; })},
      {"ReplayWithoutCheckpointing", restarting, "a replay round needs checkpointing",
       on_round([](RoundPlace p) { return p.round.replay = p.index == 1; })},
      {"RestartThoughNothingOverflowed", replaying, "only an overflow lets a round restart",
       on_round([](RoundPlace p) { return p.round.replay && !(p.round.replay = false); })},
      {"ReplayAfterOverflow", overflowing, "the round after an overflow must start at the root",
       on_round([](RoundPlace p) { return p.index > 0 && !p.round.replay && (p.round.replay = true); })},
      {"OverflowWithoutCheckpointing", restarting, "only checkpointing can overflow",
       on_round([](RoundPlace p) { return p.round.overflow = true; })},
      {"RoundAfterTermination", restarting, "no round may follow the one that terminated",
       on_round([](RoundPlace p) { return !p.last && (p.round.terminated = true); })},
      {"RoundAfterAPartlyFilledOne", replaying, "a round may only follow one that filled the k-buffer",
       on_round([](RoundPlace p) {
         if (!p.last || p.round.terminated) return false;
         Round empty;
         empty.replay = true;
         p.ray.rounds.push_back(empty);
         return true;
       })},
      {"RayEndsTooEarly", replaying, "the ray must go on", on_round(truncate_to)},
      {"RayWithoutCheckpointingEndsTooEarly", restarting, "the ray must go on", on_round(truncate_to)},
      {"EventCountTooLarge", restarting, "event_count exceeds",
       on_round([](RoundPlace p) { return p.last && ++p.round.event_count; })},
      {"ProcessedCountTooLarge", restarting, "processed_count exceeds",
       on_round([](RoundPlace p) { return p.last && ++p.round.processed_count; })},
      // k-buffer
      {"PreloadedWithoutEvictions", replaying, "preloaded must be",
       on_round([](RoundPlace p) { return ++p.round.preloaded; })},
      {"PreloadedLessThanPossible", replaying, "preloaded must be",
       on_round([](RoundPlace p) { return p.round.preloaded > 0 && p.round.preloaded--; })},
      {"KCountWrong", replaying, "k_count must be preloaded plus inserted",
       on_round([](RoundPlace p) { return ++p.round.k_count; })},
      {"MoreProcessedThanHeld", restarting, "no more entries can be processed", on_round([](RoundPlace p) {
         if (!p.last) return false;
         p.round.processed_count = static_cast<std::uint16_t>(p.round.k_count + 1);
         p.ray.processed.resize(p.first_processed + p.round.processed_count);
         return true;
       })},
      {"EntryLeftUnprocessed", restarting, "all entries must be processed", on_round([](RoundPlace p) {
         if (!p.last || p.round.terminated || p.round.k_count == 0) return false;
         --p.round.processed_count;
         p.ray.processed.pop_back();
         return true;
       })},
      {"ProcessedEntryBehindTheRounds", restarting, "processed entries remain",
       on_round([](RoundPlace p) { return p.ray.processed.emplace_back(), true; })},
      {"ProcessedGaussianUnknown", restarting, "a processed Gaussian must be in the scene", on_round([](RoundPlace p) {
         if (p.ray.processed.empty()) return false;
         p.ray.processed[0].gaussian = static_cast<std::uint32_t>(p.header.gaussians & 0x7FFFFFFF);
         return true;
       })},
      {"InsertionWithoutRoom", restarting, "an insertion needs room",
       becomes(LeafOutcome::displaced, LeafOutcome::inserted)},
      {"RejectionWithRoom", restarting, "only a full k-buffer", becomes(LeafOutcome::inserted, LeafOutcome::rejected)},
      {"TooManyShifts", restarting, "cannot shift more entries", on_event([](EventPlace p) {
         if (!is_leaf(p.event, LeafOutcome::inserted)) return false;
         set_leaf(p.event, LeafOutcome::inserted, p.occupied + 1);
         return true;
       })},
      {"TooManyShiftsOfAFullBuffer", restarting, "cannot shift more entries", on_event([](EventPlace p) {
         if (!is_leaf(p.event, LeafOutcome::displaced)) return false;
         set_leaf(p.event, LeafOutcome::displaced, p.header.k);  // the entry displaced does not move, it falls out
         return true;
       })},
      {"ShiftsOfAMiss", restarting, "only an insertion shifts", becomes(LeafOutcome::miss, LeafOutcome::miss, 1)},
      {"UnknownOutcome", restarting, "the leaf outcome must be known", on_event([](EventPlace p) {
         if (p.event.kind() != EventKind::visit_leaf) return false;
         set_leaf(p.event, static_cast<LeafOutcome>(8));
         return true;
       })},
      // Evictions
      {"LostEviction", replaying, "preloaded must be", on_round([](RoundPlace p) {
         // All evictions of this round are preloaded by the next one.
         if (p.last || p.ray.rounds[p.index + 1].preloaded == p.header.k) return false;
         for (std::size_t e = p.first_event; e < p.first_event + p.round.event_count; ++e) {
           if (!is_leaf(p.ray.events[e], LeafOutcome::rejected)) continue;
           set_leaf(p.ray.events[e], LeafOutcome::ignored);
           return true;
         }
         return false;
       })},
      {"EvictionsKeptAcrossOverflow", overflowing, "must drop the whole eviction buffer",
       on_round([](RoundPlace p) { return p.round.overflow && !p.last && p.round.eviction_dropped-- > 0; })},
      {"EvictionsDroppedWithoutOverflow", replaying, "evictions are only dropped by an overflow",
       on_round([](RoundPlace p) { return p.round.eviction_dropped = 1; })},
      // Checkpoints
      {"CapacityExceeded", replaying, "than the buffer holds",
       [](RandomTrace& trace) { return trace.header.checkpoint_capacity = 2; }},
      {"CheckpointWithoutCheckpointing", restarting, "no checkpoints without checkpointing",
       on_event([](EventPlace p) { return p.event.kind() == EventKind::cull && (p.event.checkpoints = 1); })},
      {"CheckpointBeforeTheKBufferIsFull", replaying, "once the k-buffer is full", on_event([](EventPlace p) {
         if (p.occupied == p.header.k || !is_leaf(p.event, LeafOutcome::miss) || p.round.terminated) return false;
         set_leaf(p.event, LeafOutcome::beyond, 0, true);
         return true;
       })},
      {"CulledNodeLost", replaying, "may not be dropped",
       on_event([](EventPlace p) { return p.event.kind() == EventKind::cull && (p.event.checkpoints = 0, true); })},
      {"ForwardedNodeLost", replaying, "may not be dropped", on_event([](EventPlace p) {
         return p.event.kind() == EventKind::replay_forward && (p.event.checkpoints = 0, true);
       })},
      {"TwoCheckpointsOfOneNode", replaying, "at most one checkpoint",
       on_event([](EventPlace p) { return p.event.kind() == EventKind::cull && (p.event.checkpoints = 3); })},
      {"CheckpointOfAMiss", replaying, "only a leaf beyond t_max",
       on_event([](EventPlace p) { return is_leaf(p.event, LeafOutcome::miss) && (p.event.checkpoints = 1); })},
      {"PushedAndCheckpointed", replaying, "either pushed or checkpointed", on_event([](EventPlace p) {
         if (p.event.kind() != EventKind::visit_internal || p.event.checkpoints == 0) return false;
         p.event.detail |= p.event.checkpoints;
         return true;
       })},
      {"ChildThatDoesNotExist", replaying, "exceed the child count",
       on_event([](EventPlace p) { return p.event.kind() == EventKind::visit_internal && (p.event.detail |= 0x80); })},
      {"SourceEntryNotRead", replaying, "every source entry must be read", on_event([](EventPlace p) {
         return p.event.kind() == EventKind::replay_forward && p.last_in_round && drop(p);
       })},
      {"SourceEntryReadTwice", replaying, "no source entry is left to read", on_event([](EventPlace p) {
         return p.event.kind() == EventKind::replay_forward && p.last_in_round && repeat(p);
       })},
      {"SourceEntryOutOfOrder", replaying, "must be the next source entry",
       on_event([](EventPlace p) { return p.event.kind() == EventKind::replay_take && ++p.event.node; })},
      {"TransformMissing", replaying, "must follow the take of a node inside an instance", on_event([](EventPlace p) {
         return p.event.kind() == EventKind::visit_instance && p.event.detail == 1 && drop(p);
       })},
      {"TransformByAnotherInstance", replaying, "through which the node was checkpointed", on_event([](EventPlace p) {
         return p.event.kind() == EventKind::visit_instance && p.event.detail == 1 && ++p.event.node;
       })},
      {"TransformWithoutTake", replaying, "transformed for alone", on_event([](EventPlace p) {
         return p.event.kind() == EventKind::visit_instance && p.event.detail == 0 && (p.event.detail = 1);
       })},
      {"SceneTransformMissing", placed, "the instance must be the one", on_event([](EventPlace p) {
         if (p.event.kind() != EventKind::visit_instance || p.event.detail != 1 || p.last_in_round) return false;
         const Event& next = p.ray.events[p.index + 1];
         if (next.kind() != EventKind::visit_instance || next.detail != 1) return false;
         return drop(p);
       })},
      {"ObjectTransformMissing", placed, "must follow the take of a node inside an instance",
       on_event([](EventPlace p) {
         if (p.event.kind() != EventKind::visit_instance || p.event.detail != 1) return false;
         if (in_scene(p.header, p.event.node)) return false;
         return drop(p);
       })},
      {"TransformToAnotherObject", placed, "through which the node was checkpointed", on_event([](EventPlace p) {
         return p.event.kind() == EventKind::visit_instance && p.event.detail == 1 &&
                in_scene(p.header, p.event.node) && ++p.event.node;
       })},
      {"SceneLeafThatTheHeaderDoesNotName", placed, "must be one of the header's scene_leaves",
       [](RandomTrace& trace) {
         return trace.header.scene_leaves.assign(1, {trace.header.root, 0}), true;
       }},
      // Stack
      {"StackNotEmptyAtRoundEnd", restarting, "the stack must be empty",
       on_event([](EventPlace p) { return p.last_in_round && drop(p); })},
      {"VisitFromAnEmptyStack", restarting, "the stack is empty",
       on_event([](EventPlace p) { return p.last_in_round && repeat(p); })},
      {"NodeNotOnTop", restarting, "must be on top of the stack",
       on_event([](EventPlace p) { return p.event.kind() == EventKind::cull && ++p.event.node; })},
      {"LowestSlotPopped", following, "must be on top of the stack", on_event([](EventPlace p) {
         // A node that pushes several leaves: the first to be popped gets the name of the one below it.
         return p.event.kind() == EventKind::visit_leaf && !p.last_in_round &&
                (&p.event)[1].kind() == EventKind::visit_leaf && (&p.event)[1].node < p.event.node &&
                (std::swap(p.event.node, (&p.event)[1].node), true);
       })},
      {"CullWithoutPopTest", restarting, "without pop_test no stack entry holds a t",
       [](RandomTrace& trace) { return (trace.header.pop_test = PopTest::off, true); }},
      {"ReadFromAFullStack", replaying, "the stack is not empty", on_event([](EventPlace p) {
         return p.event.kind() == EventKind::cull &&
                (p.event.kind_shifts = Event::pack(EventKind::replay_forward), true);
       })},
      {"LeafVisitedAsInstance", replaying, "is not an instance leaf", on_event([](EventPlace p) {
         return is_leaf(p.event, LeafOutcome::miss) &&
                (p.event.kind_shifts = Event::pack(EventKind::visit_instance), true);
       })},
      {"InstanceVisitedAsLeaf", replaying, "is not a leaf", on_event([](EventPlace p) {
         if (p.event.kind() != EventKind::visit_instance || p.event.detail != 0) return false;
         set_leaf(p.event, LeafOutcome::miss);
         return true;
       })},
      {"InstanceInAMonolithicStructure", restarting, "needs a two-level structure", on_event([](EventPlace p) {
         return is_leaf(p.event, LeafOutcome::miss) &&
                (p.event.kind_shifts = Event::pack(EventKind::visit_instance), true);
       })},
      {"UnknownEventKind", restarting, "its top must be visited or culled",
       on_event([](EventPlace p) { return p.event.kind() == EventKind::cull && (p.event.kind_shifts = 7); })},
      {"WideLeafVisitedAsANarrowOne", wide, "as wide as its parent says", on_event([](EventPlace p) {
         return p.event.kind() == EventKind::visit_leaf && p.event.wide() &&
                (p.event.kind_shifts ^= Event::kWide, true);
       })},
      {"InstanceVisitedAsAWideOne", wide_instances, "as wide as its parent says", on_event([](EventPlace p) {
         return p.event.kind() == EventKind::visit_instance && p.event.detail == 0 &&
                (p.event.kind_shifts ^= Event::kWide, true);
       })},
      {"InstanceOfAReplayVisitedAsAWideOne", wide_instances, "as wide as its parent says", on_event([](EventPlace p) {
         return p.event.kind() == EventKind::visit_instance && p.event.detail == 1 &&
                (p.event.kind_shifts ^= Event::kWide, true);
       })},
      {"WideLeafWhereTheHeaderHasNone", wide, "of a known kind",
       [](RandomTrace& trace) { return trace.header.wide_leaves = 0, true; }},
      {"NodeIndexBeyondTheDictionary", restarting, "exceeds the dictionary", on_event([](EventPlace p) {
         return p.event.kind() == EventKind::visit_internal && (p.event.node = 0xFFFFFFFF);
       })},
      {"EventsBehindTheRounds", restarting, "events remain",
       on_round([](RoundPlace p) { return p.ray.events.emplace_back(), true; })},
      // How a round collects hits
      {"NearestHitInMultiRoundTracing", restarting, "only closest-hit tracing commits",
       becomes(LeafOutcome::inserted, LeafOutcome::nearest)},
      {"NearestHitInSingleRoundTracing", single_round, "only closest-hit tracing commits",
       becomes(LeafOutcome::inserted, LeafOutcome::nearest)},
      {"AnyHitInClosestHitTracing", closest_hit, "calls no any-hit shader", on_event([](EventPlace p) {
         if (!is_leaf(p.event, LeafOutcome::nearest) || p.occupied != 0) return false;
         set_leaf(p.event, LeafOutcome::inserted);
         return true;
       })},
      {"TieReportedInClosestHitTracing", closest_hit, "calls no any-hit shader",
       becomes(LeafOutcome::behind, LeafOutcome::ignored)},
      {"NearestHitLost", closest_hit, "k_count must be", on_round([](RoundPlace p) {
         unsigned found = 0;
         Event* nearest = nullptr;
         for (std::uint32_t e = 0; e < p.round.event_count; ++e) {
           Event& event = p.ray.events[p.first_event + e];
           if (!is_leaf(event, LeafOutcome::nearest)) continue;
           ++found;
           nearest = &event;
         }
         if (found == 1) set_leaf(*nearest, LeafOutcome::miss);
         return found == 1;
       })},
      {"AppendMovesEntries", single_round, "appends without moving", on_event([](EventPlace p) {
         if (!is_leaf(p.event, LeafOutcome::inserted) || p.occupied == 0 || p.occupied + 1 >= p.header.k) return false;
         set_leaf(p.event, LeafOutcome::inserted, 1);
         return true;
       })},
      {"HeapMovesTooManyEntries", single_round, "at most log2(k)",
       becomes(LeafOutcome::displaced, LeafOutcome::displaced, 3)},
      {"AppendToAListMovesEntries", list, "appends without moving", on_event([](EventPlace p) {
         if (!is_leaf(p.event, LeafOutcome::inserted) || p.occupied == 0 || p.occupied + 1 >= p.header.k) return false;
         set_leaf(p.event, LeafOutcome::inserted, 1);
         return true;
       })},
      {"ListDisplacesWithRoomLeft", list, "only a full k-buffer displaces", on_event([](EventPlace p) {
         if (!is_leaf(p.event, LeafOutcome::inserted) || p.occupied == p.header.k) return false;
         set_leaf(p.event, LeafOutcome::displaced, 0);
         return true;
       })},
      // When any-hit shaders run, and when a ray's end is tested
      {"CullWithDelayedAnyHitShaders", delayed, "nothing that was pushed lies beyond it", on_event([](EventPlace p) {
         return is_leaf(p.event, LeafOutcome::miss) && (p.event.kind_shifts = Event::pack(EventKind::cull), true);
       })},
      {"ImmediateTraceThatSaysDelayed", restarting, "with delayed any-hit shaders",
       [](RandomTrace& trace) { return (trace.header.any_hit = AnyHit::delayed, true); }},
      {"ImmediateTraceWithoutPopTestThatSaysDelayed", stale_nodes, "with delayed any-hit shaders",
       [](RandomTrace& trace) { return (trace.header.any_hit = AnyHit::delayed, true); }},
      {"HitBeyondTheTmaxOfThisRoundsHits", delayed, "is so in all later rounds", on_round([](RoundPlace p) {
         // A hit that falls out of the first round and comes back in the second is lost instead.
         if (p.index != 0 || p.last) return false;
         for (std::uint32_t e = 0; e < p.round.event_count; ++e) {
           Event& event = p.ray.events[p.first_event + e];
           if (!is_leaf(event, LeafOutcome::rejected)) continue;
           set_leaf(event, LeafOutcome::beyond);
           return true;
         }
         return false;
       })},
      {"MoreNodesThanInTheRoundBefore", delayed, "no round may visit more nodes", on_round([](RoundPlace p) {
         if (p.index == 0) return false;
         Event first = p.ray.events[p.first_event];
         p.ray.events.insert(p.ray.events.begin() + static_cast<std::ptrdiff_t>(p.first_event), first);
         return ++p.round.event_count != 0;
       })},
      {"EntryBehindTheEndOfARayLeftOut", tested_once_a_round, "when termination is tested once a round",
       on_round([](RoundPlace p) {
         if (!p.round.terminated) return false;
         --p.round.processed_count;
         p.ray.processed.erase(p.ray.processed.begin() + static_cast<std::ptrdiff_t>(p.first_processed));
         return true;
       })},
      // Group
      {"PixelOutsideTheImage", restarting, "the pixel must lie in the image",
       on_round([](RoundPlace p) { return p.ray.pixel = 640 * 480; })},
      {"MoreRaysThanLanes", restarting, "at most warp_size rays",
       [](RandomTrace& trace) { return trace.groups[0].rays.resize(trace.header.warp_size + 1), true; }},
      {"NodeNeverVisited", restarting, "every node of the dictionary must be visited",
       [](RandomTrace& trace) {
         NodeDefinition node = trace.groups[1].nodes.back();
         ++node.address;
         trace.groups[1].nodes.push_back(node);
         return true;
       }},
      {"NodesOutOfOrder", restarting, "nodes must ascend",
       [](RandomTrace& trace) { return std::swap(trace.groups[1].nodes[0], trace.groups[1].nodes[1]), true; }},
      {"NodeOutsideTheImage", restarting, "must lie in the node image",
       [](RandomTrace& trace) { return trace.header.node_image_bytes = 128; }},
      {"ChildrenOutsideTheImage", restarting, "must lie in the node image",
       [](RandomTrace& trace) { return trace.groups[1].nodes[0].child_base = 0xFFFFFFFF; }},
      {"MoreChildrenThanTheWidth", restarting, "1..bvh_width children",
       [](RandomTrace& trace) { return trace.groups[1].nodes[0].child_count = 9; }},
      {"UnusedSlotNotInternal", restarting, "unused child slot",
       [](RandomTrace& trace) { return trace.groups[1].nodes[0].child_kinds[7] = NodeKind::triangle, true; }},
      {"UnknownChildKind", restarting, "of a known kind",
       [](RandomTrace& trace) { return trace.groups[1].nodes[0].child_kinds[0] = static_cast<NodeKind>(2), true; }},
  };
}

// The first rule broken in memory; "" when all hold.
std::string fault_in_memory(const RandomTrace& trace, std::string& place) {
  try {
    for (const RayGroup& group : trace.groups) check_group("memory", trace.header, group);
  } catch (const Error& error) {
    place = error.place();
    return error.rule();
  }
  return "";
}

// The first rule broken in a file; "unwritable" when the writer refuses the trace as our own fault.
std::string fault_in_file(const RandomTrace& trace, std::string& place) {
  const testing::TemporaryFile file;
  try {
    testing::write_trace(file.path(), trace.header, trace.groups);
  } catch (const std::logic_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("trace group "));
    return "unwritable";
  }
  const Reader reader(file.path());
  try {
    check(reader, true);
  } catch (const Error& error) {
    EXPECT_EQ(error.file(), file.path());
    place = error.place();
    return error.rule();
  }
  return "";
}

TEST(Check, SoundTracesPass) {
  for (auto* base : {replaying, placed, overflowing, restarting, delayed, stale_nodes, tested_once_a_round,
                     single_round, list, closest_hit}) {
    const RandomTrace trace = base();
    std::string place;
    EXPECT_EQ(fault_in_memory(trace, place), "") << place;
    EXPECT_EQ(fault_in_file(trace, place), "") << place;
  }
}

TEST(Check, CatchesEveryMutation) {
  std::size_t written = 0;
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    RandomTrace trace = c.base();
    if (!c.mutate(trace)) {
      ADD_FAILURE() << "the mutation found no place";
      continue;
    }
    std::string place;
    EXPECT_THAT(fault_in_memory(trace, place), HasSubstr(c.rule));
    EXPECT_THAT(place, MatchesRegex("group [0-9]+( lane [0-9]+( round [0-9]+( event [0-9]+)?)?)?"));
    std::string place_in_file;
    const std::string in_file = fault_in_file(trace, place_in_file);
    if (in_file == "unwritable") continue;
    ++written;
    EXPECT_THAT(in_file, HasSubstr(c.rule));
    EXPECT_EQ(place_in_file, place);
  }
  EXPECT_GE(written, 20U) << "rules that only check() can hold";
}

TEST(Check, ReturnsTheStoredTotals) {
  const RandomTrace trace = overflowing();
  const testing::TraceFile file(trace.header, trace.groups);
  const Reader reader(file.path());
  EXPECT_EQ(check(reader, true), reader.totals());
  EXPECT_GT(reader.totals().overflows, 0U);
  EXPECT_EQ(reader.totals().max_checkpoints_per_round, trace.header.checkpoint_capacity);
}

TEST(Check, NamesTheFirstOfSeveralFaults) {
  RandomTrace trace = restarting();
  for (const std::size_t g : {2U, 4U, 5U}) {
    for (Ray& ray : trace.groups[g].rays) ray.pixel = 640 * 480;
  }
  std::string place;
  EXPECT_EQ(fault_in_file(trace, place), "the pixel must lie in the image");
  EXPECT_EQ(place, "group 2 lane 0");
}

}  // namespace
}  // namespace grtx::traces
