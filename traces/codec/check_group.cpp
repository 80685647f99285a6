// SPDX-License-Identifier: Apache-2.0
#include "grtx/traces/check.h"

#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <set>
#include <span>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/traces/codec/checked_nodes.h"
#include "grtx/traces/codec/group_model.h"
#include "grtx/traces/codec/pop_order.h"
#include "grtx/traces/codec/wide_leaves.h"
#include "grtx/traces/rules/checkpoint_lists.h"
#include "grtx/traces/rules/round_rules.h"
#include "grtx/traces/source_assignment.h"

namespace grtx::traces {
namespace {

class GroupChecker {
 public:
  [[gnu::noinline]] Totals check(const std::string& file, const Header& header, const RayGroup& group) {
    file_ = &file;
    header_ = &header;
    group_ = &group;
    lane_ = round_ = event_ = kNowhere;
    totals_ = Totals{};
    pop_order_ = PopOrder(header.child_order);
    rules_ = RoundRules(header);
    checkpoints_ = CheckpointLists<NodeReference>(header);
    delayed_ = header.any_hit == AnyHit::delayed;
    bounded_ = header.opacity_bound == OpacityBound::on;
    in_order_ = header.ahead == 1;
    require(group.rays.size() <= header.warp_size, "a group holds at most warp_size rays");
    require(header.colour == ColourPer::hit || group.kind == RayKind::primary,
            "colours that are made once in a frame are for rays from the camera");
    root_known_ = false;
    if (const char* const fault = nodes_.take(header, group.nodes); fault != nullptr) fail(fault);
    wide_leaves_.take(group.nodes, header.node_sizes());
    for (lane_ = 0; lane_ < group.rays.size(); ++lane_) check_ray(group.rays[lane_]);
    lane_ = kNowhere;
    require(nodes_.all_visited(), "every node of the dictionary must be visited");
    return totals_;
  }

 private:
  static constexpr std::size_t kNowhere = ~std::size_t{0};
  static constexpr std::uint32_t kRootParent = GroupModel::kRootParent;
  static constexpr const char* kRuleWidth = "a visited leaf must be as wide as its parent says";

  [[noreturn, gnu::cold, gnu::noinline]] void fail(const char* rule) const {
    std::string place = "group " + std::to_string(group_->index);
    if (lane_ != kNowhere) place += " lane " + std::to_string(lane_);
    if (round_ != kNowhere) place += " round " + std::to_string(round_);
    if (event_ != kNowhere) place += " event " + std::to_string(event_);
    throw Error(*file_, place, rule);
  }
  [[gnu::always_inline]] void require(bool holds, const char* rule) const {
    if (!holds) [[unlikely]]
      fail(rule);
  }

  void check_ray(const Ray& ray) {
    ++totals_.rays;
    const std::uint64_t pixels = static_cast<std::uint64_t>(header_->width) * header_->height;
    require(ray.pixel < pixels, "the pixel must lie in the image");
    checkpoints_.begin_ray();
    bins_ = ray.bins;
    evictions_ = 0;
    beyond_end_.clear();
    ends_early_ = false;
    std::size_t next_event = 0;
    std::size_t next_processed = 0;
    for (round_ = 0; round_ < ray.rounds.size(); ++round_) {
      const Round& round = ray.rounds[round_];
      require(round.event_count <= ray.events.size() - next_event, "event_count exceeds the ray's events");
      require(round.processed_count <= ray.processed.size() - next_processed,
              "processed_count exceeds the ray's entries");
      begin_round(round, round_ == 0 ? nullptr : &ray.rounds[round_ - 1]);
      check_events({ray.events.data() + next_event, round.event_count}, round);
      end_round(round, round_ + 1 == ray.rounds.size());
      check_processed({ray.processed.data() + next_processed, round.processed_count});
      next_event += round.event_count;
      next_processed += round.processed_count;
    }
    round_ = kNowhere;
    require(next_event == ray.events.size(), "events remain behind the last round");
    require(next_processed == ray.processed.size(), "processed entries remain behind the last round");
    require(bins_.empty(), "each bin must be that of an entry written");
    require(!ends_early_ || ray.rounds.back().terminated,
            "a ray that leaves out what its hits hide must be terminated by them");
  }

  void begin_round(const Round& round, const Round* before) {
    ++totals_.rounds;
    if (before != nullptr && !rules_.goes_on(*before)) {
      fail(before->terminated ? "no round may follow the one that terminated the ray"
                              : "a round may only follow one that filled the k-buffer");
    }
    if (const bool replays = before != nullptr && rules_.replays_after(*before); round.replay != replays) {
      fail(replays             ? "a checkpoint written must be read: only an overflow lets a round restart at the root"
           : before == nullptr ? "the first round must start at the root"
           : header_->checkpoint ? "the round after an overflow must start at the root"
                                 : "a replay round needs checkpointing");
    }
    require(header_->checkpoint || !round.overflow, "only checkpointing can overflow");
    require(!delayed_ || before == nullptr || round.event_count <= before->event_count,
            "with delayed any-hit shaders no round may visit more nodes than the one before");
    const std::uint64_t preload = rules_.preloaded(evictions_);
    const bool shortened = bounded_ && round.preloaded != 0 && round.preloaded < preload;
    require(round.preloaded == preload || shortened,
            "preloaded must be the smaller of k and the evictions kept (0 without checkpointing)");
    evictions_ -= round.preloaded;
    ends_early_ |= shortened;
    overfull_ = false;
    occupied_ = round.preloaded;
    written_ = 0;
  }

  void end_round(const Round& round, bool last) {
    require(round.k_count == occupied_, "k_count must be preloaded plus inserted minus hidden");
    require(!overfull_ || occupied_ == header_->k || ends_early_, "only a full k-buffer displaces or rejects");
    require(round.processed_count <= round.k_count, "no more entries can be processed than the k-buffer holds");
    require(round.terminated || round.processed_count == round.k_count,
            "all entries must be processed unless the ray terminates");
    require(header_->ert_check == ErtCheck::hit || round.processed_count == round.k_count,
            "all entries must be processed when termination is tested once a round");
    require(!last || !rules_.goes_on(round), "the ray must go on: its k-buffer was full and it was not terminated");
    totals_.max_checkpoints_per_round = std::max(totals_.max_checkpoints_per_round, written_);
    totals_.max_evictions_per_ray = std::max(totals_.max_evictions_per_ray, evictions_);
    if (round.overflow) {
      ++totals_.overflows;
      checkpoints_.drop_written();
      const bool unused = last && round.eviction_dropped == 0;  // the last round needs no eviction buffer
      require(unused || round.eviction_dropped == evictions_, "an overflow must drop the whole eviction buffer");
      evictions_ -= round.eviction_dropped;
    } else {
      require(round.eviction_dropped == 0, "evictions are only dropped by an overflow");
    }
  }

  void check_processed(std::span<const Processed> entries) {
    for (const Processed& entry : entries) {
      require(entry.gaussian < header_->gaussians, "a processed Gaussian must be in the scene");
      ++totals_.processed;
      totals_.blended += entry.blended;
    }
  }

  // Sets up the source entries left by the previous round, and their read order.
  void open_source(std::span<const Event> events, const Round& round) {
    require(checkpoints_.has_bins() && round.replay ? checkpoints_.bins().allows(round.bins) : round.bins == BinOrder{},
            "a replay must read bins of the header");
    checkpoints_.begin_round(round.replay, round.bins);
    assigned_ = nullptr;
    if (checkpoints_.order().by_place() || !round.replay) return;
    addresses_.clear();
    for (const NodeReference& entry : checkpoints_.source()) {
      addresses_.push_back(nodes_[entry.parent].child_address(entry.slot));
    }
    assigned_ = &assignment_.assign(addresses_, checkpoints_.source(), events, nodes_.levels());
  }

  void check_events(std::span<const Event> events, const Round& round) {
    open_source(events, round);
    lossless_ = header_->checkpoint && !round.overflow;
    StackFrame top{kRootParent, {}, round.replay ? 0U : 1U};
    std::size_t depth = 0;  // frames below the top one
    CheckedNode* const nodes = nodes_.begin();
    const std::uint32_t first_node = nodes_.first_node();
    std::uint64_t visits_internal = 0;
    std::uint64_t misses = 0;
    for (event_ = 0; event_ < events.size(); ++event_) {
      const Event& event = events[event_];
      if (top.remaining == 0) {
        if (depth == 0) {
          top = check_read(event);
          if (top.remaining == 0) continue;
          if (nodes_.levels().is_object(event.node)) check_transform(events, top.path.scene);
          if (nodes_.levels().is_blas(event.node)) check_transform(events, top.path.instance);
          continue;
        }
        top = frames_[--depth];
      }
      const EventKind kind = event.kind();
      if (top.parent == kRootParent && !root_known_) [[unlikely]]
        learn_root(kind);
      const CheckedNode& parent = nodes[top.parent];
      const auto [slot, address] = check_pop(event, kind, parent, top, nodes);
      StackFrame pushed;
      if (kind == EventKind::visit_leaf) {
        misses += check_any_leaf(event, parent, {top.parent, slot, top.path}, address) ? 1 : 0;
        continue;
      }
      if (kind == EventKind::visit_internal) {
        require((parent.internal_mask >> slot & 1) != 0, "the node on top of the stack is not internal");
        ++visits_internal;
        pushed = check_internal(event, {first_node + event.node, top.path, event.pushed()}, nodes);
      } else if (kind == EventKind::cull) {
        check_cull(event, {top.parent, slot, top.path});
      } else {
        require(kind == EventKind::visit_instance, "the stack is not empty: its top must be visited or culled");
        pushed = check_instance(event, {top.parent, slot, top.path});
      }
      if (pushed.remaining == 0) continue;
      if (depth == frames_.size()) [[unlikely]]
        frames_.resize(2 * depth);
      frames_[depth] = top;
      depth += top.remaining != 0 ? 1 : 0;
      if (StackFrame rest; pop_order_.split(pushed, nodes[pushed.parent].internal_mask, rest)) {
        if (depth == frames_.size()) frames_.resize(2 * depth);
        frames_[depth++] = rest;
      }
      top = pushed;
    }
    event_ = kNowhere;
    totals_.visits_internal += visits_internal;
    totals_.visits_leaf += misses;
    require(top.remaining == 0 && depth == 0, "the stack must be empty at the end of a round");
    require(checkpoints_.has_bins() || !checkpoints_.more(), "every source entry must be read");
  }

  struct Pop {
    unsigned slot;
    std::uint32_t address;
  };

  // Checks that the event's node can be popped next.
  [[gnu::always_inline]] Pop check_pop(const Event& event, EventKind kind, const CheckedNode& parent, StackFrame& top,
                                       const CheckedNode* nodes) const {
    std::uint32_t address = event.node;
    if (kind == EventKind::visit_internal) {
      require(event.node < nodes_.dictionary_size(), "the node index exceeds the dictionary");
      address = nodes[nodes_.first_node() + event.node].address;
    }
    const unsigned slot = parent.slot_of(top.remaining, address);
    require(slot < kMaxWidth, "the node must be on top of the stack");
    require(!pop_order_.by_slots() || slot == pop_order_.next(top.remaining), "the node must be on top of the stack");
    top.remaining &= ~(1U << slot);
    return {slot, address};
  }

  // Checks a leaf visit. Returns whether it is a plain miss, which the caller counts.
  [[gnu::always_inline]] bool check_any_leaf(const Event& event, const CheckedNode& parent, const NodeReference& popped,
                                             std::uint32_t address) {
    require(((parent.internal_mask | parent.instance_mask) >> popped.slot & 1) == 0,
            "the node on top of the stack is not a leaf");
    require_in_image(address, 1 + (parent.wide_mask >> popped.slot & 1));
    require_width(event, popped);
    if (event.detail == static_cast<unsigned>(LeafOutcome::miss) && event.checkpoints == 0 && event.shifts() == 0) {
      return true;
    }
    check_leaf(event, popped);
    return false;
  }

  // Checks the visit of an internal node. Returns the frame that it pushes.
  [[gnu::always_inline]] StackFrame check_internal(const Event& event, const StackFrame& pushed, CheckedNode* nodes) {
    CheckedNode& node = nodes[pushed.parent];
    require((event.pushed() & event.checkpoints) == 0, "a child is either pushed or checkpointed");
    require((event.pushed() | event.checkpoints) >> node.child_count == 0, "the child masks exceed the child count");
    require(event.shifts() == 0, "only an insertion shifts");
    node.visited = true;
    for (unsigned left = event.checkpoints; left != 0; left &= left - 1) {
      write({pushed.parent, static_cast<std::uint32_t>(std::countr_zero(left)), pushed.path});
    }
    return pushed;
  }

  void check_cull(const Event& event, const NodeReference& popped) {
    require(header_->pop_test == PopTest::on, "without pop_test no stack entry holds a t to be culled by");
    require(!delayed_, "with delayed any-hit shaders t_max stays, so nothing that was pushed lies beyond it");
    require(event.detail == 0 && event.shifts() == 0, "a cull has neither detail nor shifts");
    ++totals_.culls;
    check_beyond_t_max();
    check_dropped_or_written(event, popped);
  }

  // The first event that visits the root determines its kind.
  void learn_root(EventKind kind) {
    CheckedNode& parent = nodes_[kRootParent];
    root_known_ =
        kind == EventKind::visit_internal || kind == EventKind::visit_instance || kind == EventKind::visit_leaf;
    parent.internal_mask = kind == EventKind::visit_internal ? 1 : 0;
    parent.instance_mask = kind == EventKind::visit_instance ? 1 : 0;
  }

  // Checks the event after the take of a source entry below `instance`: it must be the visit of that instance leaf.
  void check_transform(std::span<const Event> events, std::uint32_t instance) {
    ++event_;
    require(event_ < events.size(), "visit_instance must follow the take of a node inside an instance");
    const Event& event = events[event_];
    require(event.kind() == EventKind::visit_instance && event.detail == 1,
            "visit_instance with detail 1 must follow the take of a node inside an instance");
    require(event.node == instance, "the instance must be the one through which the node was checkpointed");
    require(event.checkpoints == 0 && event.shifts() == 0, "visit_instance has neither checkpoints nor shifts");
    require(event.wide() == wide_leaves_.contains(event.node), kRuleWidth);
    ++totals_.visits_instance;
  }

  // Checks the read of a source entry. Returns the frame that it pushes.
  StackFrame check_read(const Event& event) {
    const bool take = event.kind() == EventKind::replay_take;
    require(take || event.kind() == EventKind::replay_forward, "the stack is empty: only a source entry can come next");
    require(checkpoints_.more(), "no source entry is left to read");
    std::size_t place = checkpoints_.next_place();
    if (assigned_ != nullptr) {
      place = (*assigned_)[checkpoints_.reads()];
      require(place != SourceAssignment::kNone, "no unread source entry has this address");
    }
    ++totals_.checkpoints_read;
    const NodeReference entry = checkpoints_.read_from(place);
    require(event.node == nodes_[entry.parent].child_address(entry.slot), "must be the next source entry");
    require(event.detail == 0 && event.shifts() == 0, "a replay event has neither detail nor shifts");
    if (take) {
      require(event.checkpoints == 0, "a taken entry is not checkpointed again");
      return {entry.parent, entry.path, 1U << entry.slot};
    }
    check_beyond_t_max();
    check_dropped_or_written(event, entry);
    return {};
  }

  // Returns the frame that the visit pushes.
  StackFrame check_instance(const Event& event, const NodeReference& popped) {
    require(header_->two_level, "an instance leaf needs a two-level structure");
    require((nodes_[popped.parent].instance_mask >> popped.slot & 1) != 0,
            "the node on top of the stack is not an instance leaf");
    require(event.detail == 0, "only a node taken from the source buffer is transformed for alone (detail 1)");
    require(event.checkpoints == 0 && event.shifts() == 0, "visit_instance has neither checkpoints nor shifts");
    require(popped.path.instance == 0, "an instance leaf cannot lie inside the BLAS");
    const InstanceLevels& levels = nodes_.levels();
    require(levels.is_scene(event.node) == (header_->three_level() && popped.path.scene == 0),
            "a leaf of the scene TLAS leads to an object, whose leaves lead to the BLAS");
    const std::uint32_t root = levels.root_below(event.node);
    require(root != InstanceLevels::kNoRoot, "the leaf of a scene TLAS must be one of the header's scene_leaves");
    require_width(event, popped);
    const bool wide = event.wide();
    require_in_image(event.node, header_->node_sizes().units(wide ? NodeKind::wide_instance : NodeKind::instance));
    ++totals_.visits_instance;
    return {root, levels.below(popped.path, event.node), 1};
  }

  void check_leaf(const Event& event, const NodeReference& popped) {
    require(event.detail <= static_cast<unsigned>(kLastLeafOutcome), "the leaf outcome must be known");
    ++totals_.visits_leaf;
    const LeafOutcome outcome = event.outcome();
    if (calls_any_hit(outcome)) ++totals_.any_hit_calls;
    // With nodes under way at once hits came in another order than events stand, and others may have been hidden
    // before.
    const std::uint64_t held = bounded_ && !in_order_ ? 0 : occupied_;
    const char* const broken = rules_.broken_by(outcome, event.shifts(), held, in_order_);
    if (broken != nullptr) fail(broken);
    if (bounded_ && enters(outcome)) {
      check_hidden(event);
    } else {
      require(event.checkpoints == 0 || outcome == LeafOutcome::beyond, "only a leaf beyond t_max is checkpointed");
      require(event.checkpoints <= 1, "a leaf writes at most one checkpoint");
    }
    if (delayed_) check_end_of_ray(event, outcome, popped.path);
    if (event.written() != 0) write(popped);
    occupied_ = RoundRules::held_after(outcome, occupied_) - event.hidden();
    if (!evicts(outcome)) return;
    overfull_ = true;
    if (!rules_.keeps_evictions()) return;
    ++evictions_;
    ++totals_.evictions;
    totals_.max_evictions_per_ray = std::max(totals_.max_evictions_per_ray, evictions_);
  }

  // The hit at which the ray ends stays, so a hit hides fewer entries than there are then.
  void check_hidden(const Event& event) {
    require(!in_order_ || event.hidden() < RoundRules::held_after(event.outcome(), occupied_),
            "a hit hides entries of the k-buffer, but not the one that ends the ray");
    ends_early_ |= event.hidden() != 0;
  }

  // Something lies beyond t_max: the k-buffer has been filled, or the ray ends where its hits let no light through.
  void check_beyond_t_max() {
    if (!in_order_ || occupied_ == rules_.k()) return;
    require(bounded_, "t_max only shrinks, and nodes only lie beyond it, once the k-buffer is full");
    ends_early_ = true;
  }

  // With delayed any-hit shaders t_max is the end of the ray in all of its rounds, so what lies beyond it in one round
  // is hit in none.
  void check_end_of_ray(const Event& event, LeafOutcome outcome, const InstancePath& path) {
    const std::array<std::uint32_t, 3> leaf = {path.scene, path.instance, event.node};
    if (outcome == LeafOutcome::beyond) beyond_end_.insert(leaf);
    if (calls_any_hit(outcome) && !beyond_end_.empty()) {
      require(!beyond_end_.contains(leaf),
              "with delayed any-hit shaders a leaf beyond t_max is so in all later rounds");
    }
  }

  [[gnu::always_inline]] void require_width(const Event& event, const NodeReference& leaf) {
    require(event.wide() == ((nodes_[leaf.parent].wide_leaves >> leaf.slot & 1) != 0), kRuleWidth);
  }

  void require_in_image(std::uint32_t address, std::uint64_t units) const {
    require((address + units) * header_->node_sizes().unit() <= header_->node_image_bytes,
            "a leaf must lie in the node image");
  }

  // A node beyond t_max from the stack or the source buffer may be dropped only without checkpointing or after an
  // overflow of the destination, because then the next round finds it again from the root.
  void check_dropped_or_written(const Event& event, const NodeReference& node) {
    require(event.checkpoints <= 1, "a single node writes at most one checkpoint");
    require(event.checkpoints == 1 || !lossless_ || bounded_, "a node beyond t_max may not be dropped");
    ends_early_ |= event.checkpoints == 0 && lossless_;
    if (event.checkpoints != 0) write(node);
  }

  void write(const NodeReference& node) {
    require(header_->checkpoint, "no checkpoints without checkpointing");
    require(occupied_ == rules_.k(), "t_max only shrinks, and nodes are only checkpointed, once the k-buffer is full");
    ++written_;
    ++totals_.checkpoints_written;
    if (!checkpoints_.has_bins()) {
      require(!checkpoints_.full(), "a round may not write more entries than the buffer holds");
      return checkpoints_.write(node);
    }
    require(!bins_.empty(), "each entry written must have a bin");
    require(bins_[0] < checkpoints_.bins().count(), "the bin of an entry must be one of the header's");
    require(!checkpoints_.full(bins_[0]), "a bin may not hold more entries than its capacity");
    checkpoints_.write(node, bins_[0]);
    bins_ = bins_.subspan(1);
  }

  const std::string* file_ = nullptr;
  const Header* header_ = nullptr;
  const RayGroup* group_ = nullptr;
  std::size_t lane_ = kNowhere;
  std::size_t round_ = kNowhere;
  std::size_t event_ = kNowhere;
  Totals totals_;
  CheckedNodes nodes_;
  WideLeaves wide_leaves_;
  bool root_known_ = false;  ///< an event has visited the root
  std::vector<StackFrame> frames_ = std::vector<StackFrame>(64);
  RoundRules rules_{Header()};
  CheckpointLists<NodeReference> checkpoints_;
  SourceAssignment assignment_;
  std::vector<std::uint32_t> addresses_;                  ///< order nearest: addresses of the source entries
  const std::vector<std::uint32_t>* assigned_ = nullptr;  ///< order nearest: position of each read
  std::uint64_t written_ = 0;                             ///< destination entries written in this round
  std::uint64_t evictions_ = 0;                           ///< entries in the eviction buffer
  std::uint64_t occupied_ = 0;                            ///< entries in the k-buffer
  bool overfull_ = false;                                 ///< a hit of the round displaced another or was rejected
  PopOrder pop_order_;                                    ///< the header's modes, decoded once
  bool delayed_ = false;
  bool bounded_ = false;
  bool in_order_ = true;                ///< events stand as the ray came to them
  bool ends_early_ = false;             ///< bounded: the ray has left something out that its hits hide
  std::span<const std::uint8_t> bins_;  ///< bins of the ray's entries not written yet
  bool lossless_ = false;               ///< this round must keep every node beyond t_max
  std::set<std::array<std::uint32_t, 3>>
      beyond_end_;  ///< delayed: leaves beyond the ray's end: instances above, address
};

}  // namespace

Totals check_group(const std::string& file, const Header& header, const RayGroup& group) {
  // On the heap, because every member access of a thread_local object would go through the thread pointer.
  thread_local const std::unique_ptr<GroupChecker> checker = std::make_unique<GroupChecker>();
  return checker->check(file, header, group);
}

}  // namespace grtx::traces
