// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "grtx/traces/checkpoint_bins.h"
#include "grtx/traces/codec/columns.h"
#include "grtx/traces/codec/dictionary_decoder.h"
#include "grtx/traces/codec/group_codec.h"
#include "grtx/traces/codec/group_model.h"
#include "grtx/traces/codec/pop_order.h"
#include "grtx/traces/codec/predicted_pops.h"
#include "grtx/traces/codec/processed_coder.h"
#include "grtx/traces/codec/wide_leaves.h"
#include "grtx/traces/decoded_size.h"
#include "grtx/traces/orders/checkpoint_order.h"
#include "grtx/traces/rules/opacity_sum.h"

namespace grtx::traces {
namespace {

/// Leaf operations that take_leaf() handles: they shift or checkpoint, or are unknown.
constexpr unsigned kSpecialLeafOps =
    ~(1U << kLeafCullDropped | 1U << kLeafNearest | 1U << static_cast<unsigned>(LeafOutcome::miss) |
      1U << static_cast<unsigned>(LeafOutcome::behind) | 1U << static_cast<unsigned>(LeafOutcome::beyond) |
      1U << static_cast<unsigned>(LeafOutcome::rejected) | 1U << static_cast<unsigned>(LeafOutcome::ignored));

constexpr Event make_event(EventKind kind, std::uint32_t node, unsigned detail, unsigned checkpoints,
                           unsigned shifts = 0) {
  Event event;
  event.node = node;
  event.detail = static_cast<std::uint8_t>(detail);
  event.checkpoints = static_cast<std::uint8_t>(checkpoints);
  event.kind_shifts = Event::pack(kind, shifts);
  return event;
}

/// Events of the other leaf operations; their node is filled in later.
constexpr std::array<Event, kPopOp + 1> kLeafEvents = [] {
  std::array<Event, kPopOp + 1> events{};
  for (unsigned op = 0; op < events.size(); ++op) events[op] = make_event(EventKind::visit_leaf, 0, op, 0);
  events[kLeafNearest].detail = static_cast<std::uint8_t>(LeafOutcome::nearest);
  events[kLeafCullDropped] = make_event(EventKind::cull, 0, 0, 0);
  return events;
}();

class GroupDecoder {
 public:
  [[gnu::noinline]] void decode(const Header& header, const std::uint8_t* payload, std::size_t size,
                                std::uint64_t index, RayGroup& group) {
    read_order_ = ReadOrder(header.checkpoint_order);
    pop_order_ = PopOrder(header.child_order);
    two_level_ = header.two_level;
    hides_ = header.opacity_bound == OpacityBound::on;
    has_bins_ = header.checkpoint_bins != 0;
    binned_ = BinnedEntries<NodeReference>(header.checkpoint_bins, header.checkpoint_capacity);
    unpack_columns(payload, size, columns_, has_bins_ ? kColumnCount : kColumnsWithoutBins);
    readers_.begin(columns_);
    ByteReader& top = reader(Column::group);
    if (top.varint() != index) top.fail("holds the index of another group");
    group.index = static_cast<std::uint32_t>(index);
    const unsigned kind = top.u8();
    if (kind > static_cast<unsigned>(RayKind::mirror)) top.fail("holds an unknown ray kind");
    group.kind = static_cast<RayKind>(kind);
    const auto root = static_cast<NodeKind>(top.u8());
    if (root != NodeKind::internal && root != NodeKind::instance && root != NodeKind::triangle) {
      top.fail("holds an unknown root kind");
    }
    const std::uint64_t nodes = top.varint(reader(Column::node_shape).remaining());
    const std::uint64_t rays = top.varint(header.warp_size);
    const unsigned flags = top.u8();
    const bool known_flags = flags == 0 || (flags < 2 * kNodesHoldBlasRoot && (flags & kNodesInTree) != 0);
    if (!known_flags) top.fail("holds unknown flags");
    const std::uint64_t gaussians = top.varint(reader(Column::gaussian_id).remaining());
    if (nodes > group.nodes.capacity()) take_memory(nodes * (sizeof(NodeDefinition) + sizeof(NodeModel)));
    group.nodes.resize(static_cast<std::size_t>(nodes));
    nodes_ = &group.nodes;
    model_.begin(header, root);
    dictionary_.take(header, flags, group.nodes);
    inner_.begin(reader(Column::inner_gap), reader(Column::inner));
    leaves_.begin(reader(Column::leaf_gap), reader(Column::leaf));
    hits_ = reader(Column::hits);
    pops_left_ = kMaxPops;
    processed_.begin(gaussians, readers_);
    group.rays.resize(static_cast<std::size_t>(rays));
    std::int64_t pixel = 0;
    for (Ray& ray : group.rays) take_ray(ray, pixel);
    mark_wide_leaves(header.node_sizes(), group);
    inner_.expect_end();
    leaves_.expect_end();
    hits_.expect_end();
    for (const Column column : {Column::inner_gap, Column::inner, Column::leaf_gap, Column::leaf, Column::hits}) {
      reader(column) = ByteReader();
    }
    readers_.expect_end();
  }

 private:
  ByteReader& reader(Column column) { return readers_[column]; }

  void take_ray(Ray& ray, std::int64_t& pixel) {
    ByteReader& rays = reader(Column::ray);
    pixel = checked_u32(rays, pixel + unzigzag(rays.varint(4 * kU32)));
    ray.pixel = static_cast<std::uint32_t>(pixel);
    const std::uint64_t rounds = rays.varint(reader(Column::round_flags).remaining());
    if (rounds > ray.rounds.capacity()) take_memory(rounds * sizeof(Round));
    ray.rounds.resize(static_cast<std::size_t>(rounds));
    ray.processed.clear();
    destination_.clear();
    bins_.clear();
    event_count_ = 0;
    replayed_ = 0;
    std::uint64_t processed = 0;
    for (Round& round : ray.rounds) {
      take_round(round);
      processed += round.processed_count;
      const std::size_t first = event_count_;
      take_events(round);
      const std::size_t count = event_count_ - first;
      if (count > kU32) throw Malformed("a round has 2^32 events or more");
      round.event_count = static_cast<std::uint32_t>(count);
    }
    const std::uint64_t pops = event_count_ - replayed_;
    if (pops > pops_left_) fail_pops();
    pops_left_ -= pops;
    if (event_count_ > ray.events.capacity()) take_memory(event_count_ * sizeof(Event));
    if (processed > ray.processed.capacity()) take_memory(processed * sizeof(Processed));
    ray.bins.assign(bins_.begin(), bins_.end());
    ray.events.assign(events_.begin(), events_.begin() + static_cast<std::ptrdiff_t>(event_count_));
    processed_.take_ray(processed, readers_, ray.processed);
  }

  void take_round(Round& round) {
    ByteReader& flags = reader(Column::round_flags);
    const unsigned bits = flags.u8();
    if (bits > (kRoundReplay | kRoundOverflow | kRoundTerminated)) flags.fail("holds an unknown flag");
    round.replay = (bits & kRoundReplay) != 0;
    round.overflow = (bits & kRoundOverflow) != 0;
    round.terminated = (bits & kRoundTerminated) != 0;
    round.preloaded = static_cast<std::uint16_t>(reader(Column::preloaded).varint(kU16));
    round.k_count = static_cast<std::uint16_t>(reader(Column::k_count).varint(kU16));
    ByteReader& counts = reader(Column::processed_count);
    const std::int64_t processed = round.k_count - unzigzag(counts.varint(4 * kU16));
    if (processed < 0 || processed > static_cast<std::int64_t>(kU16)) counts.fail("leaves 16 bits");
    round.processed_count = static_cast<std::uint16_t>(processed);
    round.bins = {};
    if (has_bins_ && round.replay) {
      ByteReader& bins = reader(Column::bin);
      round.bins.first = static_cast<std::uint8_t>(bins.u8());
      round.bins.before_far = static_cast<std::uint8_t>(bins.u8());
      if (!binned_.places().allows(round.bins)) bins.fail("names a bin that is not there");
    }
    round.eviction_dropped = 0;
    if (round.overflow) {
      round.eviction_dropped = static_cast<std::uint32_t>(reader(Column::eviction_dropped).varint(kU32));
    }
  }

  // Sets up the source entries left by the previous round.
  void open_source(const Round& round) {
    source_.clear();
    if (round.replay) source_.swap(destination_);
    destination_.clear();
    taken_ = 0;
    last_taken_ = -1;
    if (!read_order_.by_place()) read_.assign(source_.size(), false);
    binned_.begin_round(round.replay, round.bins);
  }

  // Decodes the pops of a round, one event each. The remaining children of the top frame stay in a register, in
  // expected order, so that a leaf costs little more than storing its event.
  void take_events(const Round& round) {
    open_source(round);
    NodeModel* const nodes = model_.nodes();
    StackFrame top{GroupModel::kRootParent, {}, 1};
    if (round.replay) top.remaining = 0;
    std::size_t depth = 0;                         // frames below the top one
    Event* event = events_.data() + event_count_;  // next event to write
    const Event* end = events_.data() + events_.size();
    while (true) {
      if (top.remaining == 0) {
        if (depth != 0) {
          top = frames_[--depth];
        } else if (has_bins_ ? binned_.more() : taken_ != source_.size()) {
          if (end - event < 3) grow_events(event, end);
          if (!take_replay(event, top)) break;
          continue;
        } else {
          break;
        }
      }
      NodeModel& parent = nodes[top.parent];
      const unsigned inner = parent.internal_mask | parent.instance_mask;
      std::uint64_t left = parent.ordered(top.remaining);
      top.remaining = 0;
      do {
        if (event == end) [[unlikely]]
          grow_events(event, end);
        const Pop pop = take_pop(parent, inner, left);
        if ((inner >> pop.slot & 1) == 0) {
          take_leaf(pop, top, *event++);
          continue;
        }
        StackFrame pushed = take_inner(pop, top, parent, nodes, *event);
        ++event;
        if (pushed.remaining == 0) continue;
        if (left != 0) put_below(depth, {top.parent, top.path, NodeModel::mask_of(left)});
        if (StackFrame rest; pop_order_.split(pushed, nodes[pushed.parent].internal_mask, rest)) [[unlikely]] {
          put_below(depth, rest);
        }
        top = pushed;
        break;
      } while (left != 0);
    }
    event_count_ = static_cast<std::size_t>(event - events_.data());
    if (round.overflow) destination_.clear();
  }

  /// A popped child and its decoded symbol.
  struct Pop {
    PopReader& pops;
    unsigned slot, symbol, op;
    std::uint32_t address;
  };

  // Decodes the next pop. left: remaining children in expected order. inner: mask of children that are not leaves.
  [[gnu::always_inline]] Pop take_pop(NodeModel& parent, unsigned inner, std::uint64_t& left) {
    unsigned slot = NodeModel::first_of(left);
    PopReader& pops = (inner >> slot & 1) != 0 ? inner_ : leaves_;
    const unsigned symbol = pops.next();
    if ((symbol >> kPopRankShift & 7) != 0) {
      slot = take_rank(parent, left, symbol >> kPopRankShift & 7, pops);
      left = parent.ordered(NodeModel::mask_of(left) & ~(1U << slot));
    } else {
      left &= left - 1;
    }
    const unsigned op = (symbol & kPopOp) ^ parent.last_op[slot];
    parent.last_op[slot] = static_cast<std::uint8_t>(op);
    return {pops, slot, symbol, op, parent.child_address(slot)};
  }

  [[gnu::always_inline]] void take_leaf(const Pop& pop, const StackFrame& top, Event& event) {
    if ((pop.symbol & kPopHits) != 0) pop.pops.fail("changes hits where none are");
    if ((kSpecialLeafOps >> pop.op & 1) != 0) {
      event = take_special_leaf({top.parent, pop.slot, top.path}, pop.address, pop.op, pop.pops);
    } else {
      event = kLeafEvents[pop.op];
      event.node = pop.address;
    }
  }

  // Decodes the event of an inner node. Returns the frame that it pushes.
  [[gnu::always_inline]] StackFrame take_inner(const Pop& pop, const StackFrame& top, NodeModel& parent,
                                               NodeModel* nodes, Event& event) {
    const bool changed_hits = (pop.symbol & kPopHits) != 0;
    if (pop.op != static_cast<unsigned>(InnerOp::visit) || !parent.is_internal(pop.slot)) {
      return take_other_inner({top.parent, pop.slot, top.path}, pop.address, pop.op, changed_hits, pop.pops, event);
    }
    std::uint32_t index = parent.links[pop.slot];
    if (index == NodeModel::kUnknownLink) [[unlikely]] {
      index = find(pop.address);
      parent.links[pop.slot] = index;
    }
    NodeModel& node = nodes[index];
    if (changed_hits) change_hits(node);
    event = make_event(EventKind::visit_internal, index - model_.first_node(), node.last_hits, 0);
    return {index, top.path, node.last_hits};
  }

  [[gnu::always_inline]] void put_below(std::size_t& depth, const StackFrame& frame) {
    if (depth == frames_.size()) [[unlikely]]
      frames_.resize(2 * depth);
    frames_[depth++] = frame;
  }

  // The slot in `left` that `rank` others precede in the expected order.
  unsigned take_rank(NodeModel& parent, std::uint64_t left, unsigned rank, const PopReader& pops) const {
    const unsigned remaining = NodeModel::mask_of(left);
    if (pop_order_.by_slots() || rank >= bits_of_byte(remaining)) pops.fail("names a child that is not there");
    const unsigned slot = parent.slot_at(remaining, rank);
    parent.move_up(remaining, slot);
    return slot;
  }

  void change_hits(NodeModel& node) {
    const unsigned difference = hits_.u8();
    if (difference == 0) hits_.fail("changes nothing");
    if (difference >> node.child_count != 0) hits_.fail("names a child that is not there");
    node.last_hits = static_cast<std::uint8_t>(node.last_hits ^ difference);
  }

  // Makes room for at least three events from `next` on.
  [[gnu::noinline]] void grow_events(Event*& next, const Event*& end) {
    const auto used = static_cast<std::size_t>(next - events_.data());
    if (used - replayed_ > pops_left_) fail_pops();
    take_memory(2 * events_.size() * sizeof(Event));
    events_.resize(2 * events_.size());
    next = events_.data() + used;
    end = events_.data() + events_.size();
  }
  [[noreturn]] static void fail_pops() { throw Malformed("a group has more than 2^30 events"); }

  void checkpoint(const NodeReference& entry) {
    if (!has_bins_) [[likely]] {
      if (destination_.size() == destination_.capacity()) [[unlikely]]
        take_memory(2 * destination_.size() * sizeof(NodeReference));
      return destination_.push_back(entry);
    }
    ByteReader& bins = reader(Column::bin);
    const unsigned bin = bins.u8();
    if (bin >= binned_.places().count() || binned_.places().full(bin)) bins.fail("names a bin that has no room");
    binned_.write(bin, entry);
    bins_.push_back(static_cast<std::uint8_t>(bin));
  }

  // Few traces have wide leaves, so the others do not look for them while they decode.
  void mark_wide_leaves(const NodeSizes& sizes, RayGroup& group) {
    wide_leaves_.take(group.nodes, sizes);
    if (wide_leaves_.empty()) return;
    for (Ray& ray : group.rays) {
      for (Event& event : ray.events) {
        const bool leaf = event.kind() == EventKind::visit_leaf || event.kind() == EventKind::visit_instance;
        if (leaf && wide_leaves_.contains(event.node)) event.kind_shifts |= Event::kWide;
      }
    }
  }

  // Reads one source entry, with the stack empty; `top` is its frame if it is taken. Returns false if the round stops
  // with entries left in its bins.
  bool take_replay(Event*& event, StackFrame& top) {
    top = {};
    ByteReader& ops = reader(Column::replay_op);
    const unsigned op = ops.u8();
    if (op == static_cast<unsigned>(ReplayOp::stop) && has_bins_) return false;
    if (op > static_cast<unsigned>(ReplayOp::forward_checkpointed)) ops.fail("holds an unknown symbol");
    std::size_t index = read_order_.position(taken_, source_.size());
    if (!read_order_.by_place()) {
      ByteReader& entries = reader(Column::replay_entry);
      const std::int64_t at = last_taken_ + 1 + unzigzag(entries.varint(4 * kU32));
      if (at < 0 || static_cast<std::uint64_t>(at) >= source_.size() || read_[static_cast<std::size_t>(at)]) {
        entries.fail("names a source entry that is not there or already read");
      }
      last_taken_ = at;
      index = static_cast<std::size_t>(at);
      read_[index] = true;
    }
    ++taken_;
    ++replayed_;
    const NodeReference entry = has_bins_ ? binned_.read() : source_[index];
    const std::uint32_t address = model_[entry.parent].child_address(entry.slot);
    if (static_cast<ReplayOp>(op) == ReplayOp::take) {
      *event++ = make_event(EventKind::replay_take, address, 0, 0);
      if (model_.levels().is_object(address)) take_instance(event, entry.path.scene);
      if (model_.levels().is_blas(address)) take_instance(event, entry.path.instance);
      top = {entry.parent, entry.path, 1U << entry.slot};
      return true;
    }
    const bool checkpointed = static_cast<ReplayOp>(op) == ReplayOp::forward_checkpointed;
    *event++ = make_event(EventKind::replay_forward, address, 0, checkpointed ? 1 : 0);
    if (checkpointed) checkpoint(entry);
    return true;
  }

  // Adds the visit of the instance leaf above a taken node.
  void take_instance(Event*& event, std::uint32_t leaf) {
    ++replayed_;
    *event++ = make_event(EventKind::visit_instance, leaf, 1, 0);
  }

  // Decodes a leaf operation of kSpecialLeafOps.
  Event take_special_leaf(const NodeReference& popped, std::uint32_t address, unsigned op, const PopReader& pops) {
    if (op < kLeafBeyondCheckpointed) {  // inserted or displaced
      ByteReader& moved = reader(Column::shifts);
      const auto shifts = static_cast<unsigned>(moved.varint(kMaxShifts));
      const auto hidden = hides_ ? static_cast<unsigned>(moved.varint(kMostHidden)) : 0u;
      return make_event(EventKind::visit_leaf, address, op, hidden, shifts);
    }
    if (op != kLeafBeyondCheckpointed && op != kLeafCullCheckpointed) pops.fail("holds an unknown operation");
    checkpoint(popped);
    if (op == kLeafCullCheckpointed) return make_event(EventKind::cull, address, 0, 1);
    return make_event(EventKind::visit_leaf, address, static_cast<unsigned>(LeafOutcome::beyond), 1);
  }

  // Decodes all inner operations but the visit of an internal node without checkpoints. Returns the pushed frame.
  StackFrame take_other_inner(const NodeReference& popped, std::uint32_t address, unsigned op, bool changed_hits,
                              const PopReader& pops, Event& event) {
    if (op > static_cast<unsigned>(InnerOp::cull_checkpointed)) pops.fail("holds an unknown operation");
    const bool visit = op < static_cast<unsigned>(InnerOp::cull_dropped);
    if (visit && model_[popped.parent].is_internal(popped.slot)) {
      return take_checkpointing(popped, address, changed_hits, event);
    }
    if (changed_hits) pops.fail("changes hits where none are");
    if (!visit) {
      const bool checkpointed = op == static_cast<unsigned>(InnerOp::cull_checkpointed);
      event = make_event(EventKind::cull, address, 0, checkpointed ? 1 : 0);
      if (checkpointed) checkpoint(popped);
      return {};
    }
    if (op != static_cast<unsigned>(InnerOp::visit) || !two_level_) {
      pops.fail("holds an operation that an instance leaf cannot have");
    }
    const std::uint32_t root = model_.levels().root_below(address);
    if (root == InstanceLevels::kNoRoot) pops.fail("visits a leaf of the scene TLAS that the header does not name");
    event = make_event(EventKind::visit_instance, address, 0, 0);
    return {root, model_.levels().below(popped.path, address), 1};
  }

  // Decodes the visit of an internal node that checkpoints children. Returns the pushed frame.
  StackFrame take_checkpointing(const NodeReference& popped, std::uint32_t address, bool changed_hits, Event& event) {
    std::uint32_t& link = model_[popped.parent].links[popped.slot];
    if (link == NodeModel::kUnknownLink) link = find(address);
    const std::uint32_t index = link;
    NodeModel& node = model_[index];
    if (changed_hits) change_hits(node);
    const unsigned hits = node.last_hits;
    if (hits == 0) throw Malformed("a visit checkpoints children where none is hit");
    unsigned checkpoints = hits;
    if (!has_one_bit(hits)) {
      const unsigned gathered = reader(Column::checkpoints).u8();
      if (gathered == 0 || gathered >> bits_of_byte(hits) != 0) {
        reader(Column::checkpoints).fail("names a child that is not hit");
      }
      checkpoints = scatter_bits(gathered, hits);
    }
    for (unsigned left = checkpoints; left != 0; left &= left - 1) {
      checkpoint({index, static_cast<std::uint32_t>(std::countr_zero(left)), popped.path});
    }
    const unsigned pushed = hits & ~checkpoints;
    event = make_event(EventKind::visit_internal, index - model_.first_node(), pushed, checkpoints);
    return {index, popped.path, pushed};
  }

  /// Model index of the internal node at `address`.
  std::uint32_t find(std::uint32_t address) const {
    const auto found = std::lower_bound(nodes_->begin(), nodes_->end(), address,
                                        [](const NodeDefinition& node, std::uint32_t a) { return node.address < a; });
    if (found == nodes_->end() || found->address != address) {
      throw Malformed("a visited internal node is missing in the dictionary");
    }
    return model_.first_node() + static_cast<std::uint32_t>(found - nodes_->begin());
  }

  static constexpr std::uint64_t kU32 = std::numeric_limits<std::uint32_t>::max();
  static constexpr std::uint64_t kU16 = std::numeric_limits<std::uint16_t>::max();

  ReadOrder read_order_;
  PopOrder pop_order_;
  bool two_level_ = false;
  bool hides_ = false;  ///< the header's opacity_bound
  ColumnSet columns_;
  ColumnReaders readers_;
  GroupModel model_;
  DictionaryDecoder dictionary_{readers_, model_};
  ProcessedDecoder processed_;
  WideLeaves wide_leaves_;
  PopReader inner_;
  PopReader leaves_;
  ByteReader hits_;
  std::uint64_t pops_left_ = 0;  ///< pops that the group may still have
  std::uint64_t replayed_ = 0;   ///< events of the ray that are not pops
  const std::vector<NodeDefinition>* nodes_ = nullptr;
  std::vector<StackFrame> frames_ = std::vector<StackFrame>(64);
  std::vector<Event> events_ = std::vector<Event>(1024);  ///< events of the ray; only the first event_count_ are valid
  std::size_t event_count_ = 0;
  std::vector<NodeReference> source_;
  std::vector<NodeReference> destination_;
  std::size_t taken_ = 0;         ///< source entries read in this round
  std::int64_t last_taken_ = -1;  ///< position of the last entry read
  std::vector<bool> read_;        ///< order nearest: entries already read
  bool has_bins_ = false;
  BinnedEntries<NodeReference> binned_;  ///< replaces source_ and destination_
  std::vector<std::uint8_t> bins_;       ///< bins of the ray's entries
};

}  // namespace

void decode_group(const Header& header, const std::uint8_t* payload, std::size_t size, std::uint64_t index,
                  RayGroup& group) {
  // On the heap, because every member access of a thread_local object would go through the thread pointer.
  thread_local const std::unique_ptr<GroupDecoder> decoder = std::make_unique<GroupDecoder>();
  decoder->decode(header, payload, size, index, group);
}

}  // namespace grtx::traces
