// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/ray/ray_replay.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <span>
#include <stdexcept>

#include "grtx/base/error.h"
#include "grtx/report/ray/handled_order.h"
#include "grtx/traces/codec/byte_stream.h"
#include "grtx/traces/codec/source_assignment.h"
#include "grtx/traces/instance_levels.h"
#include "grtx/traces/rules/checkpoint_lists.h"
#include "grtx/traces/rules/round_hits.h"

// How a round is packed. Numbers are varints, times 32-bit floats, which are only there with values (NaN: not known).
//   the k-buffer, then the eviction buffer: count, then of each hit: owner + 1 (its instance leaf, or its primitive
//   leaf
//     where there is none; 0: not known), object + 1 (leaf of the scene TLAS), Gaussian + 1 (0: not known), t
//   the source list: count, then of each entry: node, instance + 1, object + 1, t
//   t_max
//   the events, in the order in which the ray came to them: a byte (kind in bits 0-2, detail or outcome in 3-5,
//     checkpointed in 6, a new t_max follows in 7), node;
//     visit_internal: a byte that counts the children pushed, a byte for the slot of each, the next to be popped first,
//     a byte with the mask of those checkpointed, t of each pushed, t of each checkpointed; visit_instance with detail
//     0: the root below; replay_*: place in the source list; visit_leaf: shifts if inserted or displaced, and t unless
//     it was missed; the new t_max
namespace grtx::report {

using traces::Event;
using traces::EventKind;
using traces::LeafOutcome;
using traces::NodeKind;

namespace {

constexpr float kUnknownTime = std::numeric_limits<float>::quiet_NaN();

std::uint32_t units_of(const traces::RayGroup& group, const Event& event) {
  return event.kind() == EventKind::visit_internal ? group.nodes[event.node].address : event.node;
}

/// The events of a round, which begin at `begin`; advances `begin` to the next round.
std::span<const Event> events_of(const traces::Ray& ray, std::size_t& begin, const traces::Round& round) {
  const std::span<const Event> events(ray.events.data() + begin, round.event_count);
  begin += round.event_count;
  return events;
}

}  // namespace

RayNodes::RayNodes(const std::string& file, const traces::Header& header, const traces::RayGroup& group,
                   const std::vector<unsigned>& lanes) {
  const auto require_tree = [&](bool added) {
    if (!added) throw Error(file, "group " + std::to_string(group.index), "no node may be a child of two");
  };
  const traces::NodeSizes sizes = header.node_sizes();
  std::vector<bool> visited(group.nodes.size());
  std::set<std::uint32_t> others;
  for (const unsigned lane : lanes) {
    for (const Event& event : group.rays[lane].events) {
      if (event.kind() == EventKind::visit_internal) {
        visited[event.node] = true;
      } else {
        others.insert(event.node);
      }
    }
  }
  std::vector<std::uint32_t> roots = {static_cast<std::uint32_t>(header.root / sizes.unit())};
  if (header.two_level) roots.push_back(static_cast<std::uint32_t>(header.blas_root / sizes.unit()));
  for (const std::uint64_t root : header.object_roots) roots.push_back(static_cast<std::uint32_t>(root / sizes.unit()));
  const NodeKind leaf = traces::has_procedural_leaves(header.accel) ? NodeKind::procedural : NodeKind::triangle;
  for (const std::uint32_t root : roots) {
    require_tree(add(root, others.contains(root) ? leaf : NodeKind::internal, 0));
  }
  std::map<std::uint32_t, std::uint32_t> first;  // address of a node -> number + 1 of its first child
  for (std::size_t i = 0; i < visited.size(); ++i) {
    if (!visited[i]) continue;
    const traces::NodeDefinition& node = group.nodes[i];
    first[node.address] = static_cast<std::uint32_t>(nodes_.size()) + 1;
    std::uint32_t child = node.child_base;
    for (unsigned slot = 0; slot < node.child_count; ++slot) {
      require_tree(add(child, node.child_kinds[slot], node.address));
      child += sizes.units(node.child_kinds[slot]);
    }
  }
  for (RayNode& node : nodes_) {
    if (node.parent != 0) node.parent = numbers_.at(node.parent) + 1;
    const auto found = first.find(node.units);
    if (found != first.end()) node.first_child = found->second;
  }
}

/// parent: address of the parent in units; 0 for a root, as no node lies at address 0 (the headers do). Returns false
/// if the node is there already.
bool RayNodes::add(std::uint32_t units, NodeKind kind, std::uint32_t parent) {
  if (!numbers_.emplace(units, static_cast<std::uint32_t>(nodes_.size())).second) return false;
  RayNode& node = nodes_.emplace_back();
  node.units = units;
  node.kind = kind;
  node.parent = parent;
  return true;
}

namespace {

/// A node on the stack or in a checkpoint list. instance, object: node numbers + 1, 0 for none.
struct NodeEntry {
  std::uint32_t node = 0, instance = 0, object = 0;
  float t = kUnknownTime;
};

/// A hit in the k-buffer or the eviction buffer. owner, object, gaussian: numbers + 1, 0 if unknown or none.
struct HitEntry {
  std::uint32_t owner = 0, object = 0, gaussian = 0;
  float t = kUnknownTime;
  std::uint32_t made = 0;  ///< serial number of the hit in the ray

  friend bool operator<(const HitEntry& a, const HitEntry& b) {
    return a.t < b.t || (a.t == b.t && a.gaussian < b.gaussian);
  }
};

class Replay {
 public:
  Replay(const std::string& file, const traces::Header& header, const traces::RayGroup& group, unsigned lane,
         const RayNodes& nodes, const RayValues* values)
      : file_(file),
        header_(header),
        group_(group),
        lane_(lane),
        ray_(group.rays[lane]),
        nodes_(nodes),
        levels_(header),
        values_(values),
        hits_(traces::RoundRules(header)),
        checkpoints_(header) {}

  ReplayedRay run() {
    // The order in which children were pushed and the Gaussians of leaves follow only from later events. A first replay
    // collects them; the second one produces the result.
    pop_orders_.resize(ray_.events.size());
    order_events();
    const RayValues* const values = std::exchange(values_, nullptr);
    replay();
    values_ = values;
    learning_ = false;
    replay();
    result_.learnt = std::move(gaussian_of_);
    return std::move(result_);
  }

 private:
  struct Pushed {
    std::vector<NodeEntry> entries;  ///< the next to pop is last, once the order is known
    std::size_t event = 0;
  };

  void require(bool holds, const char* rule) const {
    if (holds) return;
    std::string place = "group " + std::to_string(group_.index) + " lane " + std::to_string(lane_);
    place += " round " + std::to_string(result_.rounds.size() - 1);
    if (event_ != kNobody) place += " event " + std::to_string(event_);
    throw Error(file_, place, rule);
  }

  /// The order in which the events are replayed; with several nodes under way the ray came to them in another order
  /// than they stand.
  void order_events() {
    if (header_.ahead == 1) return;
    handled_.resize(ray_.events.size());
    std::size_t begin = 0;
    for (const traces::Round& round : ray_.rounds) {
      const std::size_t first = begin;
      const std::span<const Event> events = events_of(ray_, begin, round);
      const HandledOrder handled = handled_order(events, header_.ahead);
      for (std::size_t e = 0; e < events.size(); ++e) {
        handled_[first + e] = handled.events[e];
        for (const std::uint32_t child : handled.children[e]) {
          pop_orders_[first + e].push_back(slot_of(nodes_.number(units_of(group_, events[child]))));
        }
      }
    }
  }

  void replay() {
    hits_.begin_ray();
    checkpoints_.begin_ray();
    next_bin_ = 0;
    made_ = 0;
    time_ = 0;
    result_ = ReplayedRay();
    std::size_t begin = 0, processed = 0;
    for (std::size_t r = 0; r < ray_.rounds.size(); ++r) {
      const traces::Round& round = ray_.rounds[r];
      const std::size_t first = begin;
      const std::span<const Event> events = events_of(ray_, begin, round);
      RayRound& out = result_.rounds.emplace_back();
      out.round = round;
      begin_round(r, out);
      assign_sources(round, events);
      for (std::size_t e = 0; e < events.size(); ++e) {
        event_ = handled_.empty() ? e : handled_[first + e];
        take(events[event_], first + event_, out);
      }
      event_ = kNobody;
      end_round(round, processed, out);
      processed += round.processed_count;
    }
  }

  // Lists.

  void begin_round(std::size_t r, RayRound& out) {
    if (values_ != nullptr || hits_.evictions().size() < 2) {
      hits_.begin_round();
    } else {  // the trace does not tell which are nearest
      hits_.begin_round([this] { return unknown_hit(); });
    }
    if (values_ != nullptr) compare(values_->start_hits[r]);
    checkpoints_.begin_round(out.round.replay, out.round.bins);
    if (values_ != nullptr) {
      traces::with_checkpoint_order(header_.checkpoint_order,
                                    [this](auto policy) { policy.arrange(checkpoints_.source()); });
    }
    source_.clear();
    if (!checkpoints_.has_bins()) source_ = checkpoints_.source();
    for (auto rest = checkpoints_; rest.has_bins() && rest.more();) source_.push_back(rest.read());
    if (values_ != nullptr) t_max_ = values_->start_t_max[r];
    out.evictions_left = static_cast<std::uint32_t>(hits_.evictions().size());
    put_hits(out, hits_.k_buffer().entries());
    put_hits(out, hits_.evictions());
    put(out, source_.size());
    for (const NodeEntry& entry : source_) {
      put(out, entry.node);
      put(out, entry.instance);
      put(out, entry.object);
      put_time(out, entry.t);
    }
    put_time(out, t_max_);
    stack_.clear();
    if (!out.round.replay) push({{root(header_.root), 0, 0, 0.0f}}, kNobody);
  }

  void compare(const std::vector<std::pair<float, std::uint32_t>>& hits) const {
    const std::vector<HitEntry>& found = hits_.k_buffer().entries();
    const bool same =
        std::equal(hits.begin(), hits.end(), found.begin(), found.end(), [](const auto& hit, const HitEntry& entry) {
          return hit.first == entry.t && (entry.gaussian == 0 || hit.second + 1 == entry.gaussian);
        });
    if (!same) throw std::logic_error("a ray's k-buffer is not what its replay says");
  }

  void assign_sources(const traces::Round& round, std::span<const Event> events) {
    places_.clear();
    if (!round.replay || checkpoints_.order().by_place()) return;
    std::vector<std::uint32_t> addresses;
    std::vector<traces::NodeReference> references(source_.size());
    for (std::size_t i = 0; i < source_.size(); ++i) {
      addresses.push_back(node(source_[i].node).units);
      if (source_[i].object != 0) references[i].path.scene = node(source_[i].object - 1).units;
      if (source_[i].instance != 0) references[i].path.instance = node(source_[i].instance - 1).units;
    }
    places_ = assignment_.assign(addresses, references, events, levels_);
  }

  void end_round(const traces::Round& round, std::size_t processed, RayRound& out) {
    const std::vector<HitEntry>& hits = hits_.k_buffer().entries();
    require(hits.size() == round.k_count, "k_count must be the entries of the k-buffer");
    for (std::size_t i = 0; i < round.processed_count; ++i) {
      const traces::Processed entry = ray_.processed[processed + i];
      out.blended += entry.blended;
      if (!learning_ || !hits_.rules().sorted()) continue;
      gaussian_made_[hits[i].made] = entry.gaussian;
      if (hits[i].owner != 0) gaussian_of_[hits[i].owner - 1] = entry.gaussian;
    }
    if (!round.overflow) return;
    checkpoints_.drop_written();
    hits_.drop_evictions();
  }

  // Events.

  void take(const Event& event, std::size_t index, RayRound& out) {
    const EventKind kind = event.kind();
    const bool t_max_changes = values_ != nullptr && values_->t_max[index] != t_max_;
    out.packed.push_back(static_cast<std::uint8_t>(
        static_cast<unsigned>(kind) | (kind == EventKind::visit_internal ? 0u : unsigned{event.detail} << 3) |
        (kind != EventKind::visit_internal && event.checkpoints != 0 ? 0x40u : 0u) | (t_max_changes ? 0x80u : 0u)));
    put(out, nodes_.number(units_of(group_, event)));
    switch (kind) {
      case EventKind::visit_internal:
        visit_internal(event, index, out);
        break;
      case EventKind::visit_instance:
        ++out.visits[1];
        if (event.detail == 0) enter(event, index, out);
        break;
      case EventKind::visit_leaf:
        visit_leaf(event, out);
        break;
      case EventKind::cull:
        ++out.culls;
        checkpoint(pop(event), event.checkpoints, out);
        break;
      case EventKind::replay_take:
      case EventKind::replay_forward:
        read_source(event, index, out);
        break;
    }
    if (!t_max_changes) return;
    t_max_ = values_->t_max[index];
    put_time(out, t_max_);
  }

  void visit_internal(const Event& event, std::size_t index, RayRound& out) {
    ++out.visits[0];
    const NodeEntry popped = pop(event);
    const std::uint32_t first = node(popped.node).first_child - 1;
    std::vector<unsigned>& order = pop_orders_[index];
    if (learning_) {
      std::vector<NodeEntry> children;
      for (unsigned slot = 0; slot < traces::kMaxWidth; ++slot) {
        if ((event.pushed() >> slot & 1) != 0) children.push_back({first + slot, popped.instance, popped.object});
      }
      push(std::move(children), index);
    } else {
      out.packed.push_back(static_cast<std::uint8_t>(order.size()));
      for (const unsigned slot : order) out.packed.push_back(static_cast<std::uint8_t>(slot));
      out.packed.push_back(event.checkpoints);
      std::vector<NodeEntry> children;
      for (const unsigned slot : order) {
        children.push_back({first + slot, popped.instance, popped.object, next_time()});
        put_time(out, children.back().t);
      }
      std::reverse(children.begin(), children.end());
      push(std::move(children), index);
    }
    for (unsigned slot = 0; slot < traces::kMaxWidth; ++slot) {
      if ((event.checkpoints >> slot & 1) == 0) continue;
      const float t = next_time();
      checkpoint({first + slot, popped.instance, popped.object, t}, 1, out);
      if (!learning_) put_time(out, t);
    }
  }

  /// Enters the tree below an instance leaf.
  void enter(const Event& event, std::size_t index, RayRound& out) {
    const NodeEntry popped = pop(event);
    const std::uint32_t below = levels_.root_below(event.node);
    const bool blas = below == traces::InstanceLevels::kBlasRoot;
    const std::uint32_t number = blas ? root(header_.blas_root) : nodes_.number(levels_.object_root(below));
    put(out, number);
    push({{number, blas ? popped.node + 1 : 0, blas ? popped.object : popped.node + 1, popped.t}}, index);
  }

  void visit_leaf(const Event& event, RayRound& out) {
    ++out.visits[2];
    ++out.outcomes[event.detail];
    const NodeEntry popped = pop(event);
    const LeafOutcome outcome = event.outcome();
    if (traces::may_shift(outcome)) put(out, event.shifts());
    if (outcome == LeafOutcome::miss) return;
    const float t = next_time();
    put_time(out, t);
    HitEntry hit{popped.instance != 0 ? popped.instance : popped.node + 1, popped.object, 0, t, made_++};
    hit.gaussian = gaussian_of(hit);
    if (values_ != nullptr && hit.gaussian != 0) result_.met.insert(hit.gaussian - 1);
    const char* const broken = hits_.rules().broken_by(outcome, event.shifts(), hits_.k_buffer().size(), true);
    require(broken == nullptr, broken);
    NodeEntry entry = popped;
    entry.t = t;
    checkpoint(entry, event.checkpoints, out);
    hits_.take(hit, {outcome, event.shifts()}, traces::replaces(outcome) ? place_of_last() : 0);
  }

  /// Place of the k-buffer's last hit.
  std::size_t place_of_last() {
    const std::vector<HitEntry>& hits = hits_.k_buffer().entries();
    if (hits_.rules().sorted()) return hits.size() - 1;
    if (values_ == nullptr) hits_.forget([] { return HitEntry(); });  // the trace does not tell which one it is
    return static_cast<std::size_t>(std::max_element(hits.begin(), hits.end()) - hits.begin());
  }

  void read_source(const Event& event, std::size_t index, RayRound& out) {
    const traces::ReadOrder& order = checkpoints_.order();
    const std::size_t read = checkpoints_.reads();
    const std::size_t place = order.by_place() ? order.position(read, source_.size()) : places_[read];
    put(out, place);
    const NodeEntry entry = source_.at(place);
    checkpoints_.read_from(place);
    if (event.kind() == EventKind::replay_take) {
      ++out.taken;
      push({entry}, index);
    } else {
      ++out.forwarded;
      checkpoint(entry, event.checkpoints, out);
    }
  }

  void checkpoint(const NodeEntry& entry, unsigned kept, RayRound& out) {
    if (kept == 0) return;
    ++out.written;
    checkpoints_.write(entry, checkpoints_.has_bins() ? ray_.bins.at(next_bin_++) : 0u);
  }

  // The stack, as groups of entries pushed by one event.

  static constexpr std::size_t kNobody = ~std::size_t{0};

  void push(std::vector<NodeEntry> entries, std::size_t event) {
    if (!entries.empty()) stack_.push_back({std::move(entries), event});
  }
  /// Takes the event's node from the top of the stack; with several nodes under way from anywhere in it.
  NodeEntry pop(const Event& event) {
    const std::uint32_t number = nodes_.number(units_of(group_, event));
    for (auto group = stack_.rbegin(); group != stack_.rend(); ++group) {
      const auto found = std::find_if(group->entries.rbegin(), group->entries.rend(),
                                      [number](const NodeEntry& entry) { return entry.node == number; });
      if (found == group->entries.rend()) {
        if (header_.ahead == 1) break;
        continue;
      }
      const NodeEntry entry = *found;
      group->entries.erase(std::next(found).base());
      if (learning_ && header_.ahead == 1 && group->event != kNobody &&
          ray_.events[group->event].kind() == EventKind::visit_internal) {
        pop_orders_[group->event].push_back(slot_of(entry.node));
      }
      if (group->entries.empty()) stack_.erase(std::next(group).base());
      return entry;
    }
    require(false, "the node must be on the stack");
    return {};
  }

  // What is known.

  const RayNode& node(std::uint32_t number) const { return nodes_.nodes()[number]; }
  unsigned slot_of(std::uint32_t number) const { return number + 1 - node(node(number).parent - 1).first_child; }
  std::uint32_t root(std::uint64_t address) const {
    return nodes_.number(static_cast<std::uint32_t>(address / header_.node_sizes().unit()));
  }
  float next_time() { return values_ == nullptr ? kUnknownTime : values_->times[time_++]; }
  HitEntry unknown_hit() {
    HitEntry hit;
    hit.made = made_++;
    const auto known = gaussian_made_.find(hit.made);
    if (known != gaussian_made_.end()) hit.gaussian = known->second + 1;
    return hit;
  }
  std::uint32_t gaussian_of(const HitEntry& hit) const {
    const std::uint32_t local = node(hit.owner - 1).gaussian;
    if (local != kNoGaussian)
      return (hit.object == 0 || values_ == nullptr ? 0 : node(hit.object - 1).gaussian) + local + 1;
    const auto known = gaussian_of_.find(hit.owner - 1);
    return known == gaussian_of_.end() ? 0 : known->second + 1;
  }

  // What is written.

  static void put(RayRound& out, std::uint64_t value) { traces::put_varint(out.packed, value); }
  void put_time(RayRound& out, float t) const {
    if (values_ != nullptr) traces::put_u32(out.packed, std::bit_cast<std::uint32_t>(t));
  }
  void put_hits(RayRound& out, const std::vector<HitEntry>& hits) const {
    put(out, hits.size());
    for (const HitEntry& hit : hits) {
      put(out, hit.owner);
      put(out, hit.object);
      put(out, hit.gaussian);
      put_time(out, hit.t);
    }
  }

  const std::string& file_;
  const traces::Header& header_;
  const traces::RayGroup& group_;
  const unsigned lane_;
  const traces::Ray& ray_;
  const RayNodes& nodes_;
  const traces::InstanceLevels levels_;
  const RayValues* values_;

  bool learning_ = true;
  std::vector<std::size_t> handled_;                      ///< event of the round that comes next; empty: as they stand
  std::size_t event_ = kNobody;                           ///< the event of the round that is replayed
  std::vector<std::vector<unsigned>> pop_orders_;         ///< [event] slots in the order popped
  std::map<std::uint32_t, std::uint32_t> gaussian_made_;  ///< HitEntry::made -> Gaussian
  std::map<std::uint32_t, std::uint32_t> gaussian_of_;    ///< owner -> Gaussian

  std::vector<Pushed> stack_;
  traces::RoundHits<HitEntry> hits_;
  traces::CheckpointLists<NodeEntry> checkpoints_;
  std::vector<NodeEntry> source_;  ///< entries that the round may read
  std::size_t next_bin_ = 0;       ///< index into the ray's checkpoint bins
  float t_max_ = kUnknownTime;
  std::uint32_t made_ = 0;
  std::size_t time_ = 0;  ///< index into RayValues::times
  std::vector<std::uint32_t> places_;
  traces::SourceAssignment assignment_;
  ReplayedRay result_;
};

}  // namespace

ReplayedRay replay_ray(const std::string& file, const traces::Header& header, const traces::RayGroup& group,
                       unsigned lane, const RayNodes& nodes, const RayValues* values) {
  return Replay(file, header, group, lane, nodes, values).run();
}

}  // namespace grtx::report
