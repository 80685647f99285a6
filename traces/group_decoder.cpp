#include <algorithm>
#include <bit>
#include <limits>
#include <memory>
#include <stdexcept>
#include <vector>

#include "traces/columns.h"
#include "traces/group_codec.h"
#include "traces/group_model.h"

namespace grtx::traces {
namespace {

/// Pops of one kind, see GroupEncoder.
class PopReader {
 public:
  void begin(const ByteReader& gaps, const ByteReader& symbols) {
    gaps_ = gaps;
    symbols_ = symbols;
    left_ = 0;
    symbol_behind_ = false;
  }
  /// 0 when the pop is as predicted.
  unsigned next() {
    if (left_ != 0) {
      --left_;
      return 0;
    }
    if (!symbol_behind_) {
      left_ = gaps_.u8();
      symbol_behind_ = left_ != kLongGap;
      if (left_ != 0) {
        --left_;
        return 0;
      }
    }
    symbol_behind_ = false;
    const unsigned symbol = symbols_.u8();
    if (symbol == 0) symbols_.fail("holds a pop that was predicted");
    return symbol;
  }
  [[noreturn]] void fail(const char* rule) const { symbols_.fail(rule); }
  void expect_end() const {
    if (left_ != 0) gaps_.fail("counts more pops than there are");
    gaps_.expect_end();
    symbols_.expect_end();
  }

 private:
  ByteReader gaps_;
  ByteReader symbols_;
  unsigned left_ = 0;           ///< predicted pops
  bool symbol_behind_ = false;  ///< whether an unpredicted one follows them
};

class GroupDecoder {
 public:
  [[gnu::noinline]] void decode(const Header& header, const std::uint8_t* payload, std::size_t size,
                                std::uint64_t index, RayGroup& group) {
    nearest_ = header.checkpoint_order == "nearest";
    lifo_ = header.checkpoint_order == "lifo";
    slot_order_ = header.child_order == "slot";
    two_level_ = header.two_level;
    unpack_columns(payload, size, columns_);
    for (std::size_t i = 0; i < kColumnCount; ++i) {
      const auto column = static_cast<Column>(i);
      readers_[i] = ByteReader(columns_[column].data(), columns_[column].size(), column_name(column));
    }
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
    group.nodes.assign(static_cast<std::size_t>(nodes), NodeDefinition{});
    tree_masks_.assign(static_cast<std::size_t>(nodes), 0);
    tree_order_.clear();
    nodes_ = &group.nodes;
    model_.begin(header, root);
    try {
      if (flags == 0) {
        take_nodes(group.nodes);
      } else {
        take_tree(header, flags, group.nodes);
      }
    } catch (const std::invalid_argument& fault) {
      throw Malformed(fault.what());
    }
    take_first_hits();
    inner_.begin(reader(Column::inner_gap), reader(Column::inner));
    leaves_.begin(reader(Column::leaf_gap), reader(Column::leaf));
    pops_left_ = kMaxPops;
    take_gaussians(gaussians);
    group.rays.resize(static_cast<std::size_t>(rays));
    std::int64_t pixel = 0;
    for (Ray& ray : group.rays) take_ray(ray, pixel);
    inner_.expect_end();
    leaves_.expect_end();
    for (const Column column : {Column::inner_gap, Column::inner, Column::leaf_gap, Column::leaf}) {
      reader(column) = ByteReader();
    }
    for (const ByteReader& column : readers_) column.expect_end();
  }

 private:
  ByteReader& reader(Column column) { return readers_[static_cast<std::size_t>(column)]; }

  static std::uint32_t checked_u32(const ByteReader& from, std::int64_t value) {
    if (value < 0 || value > std::numeric_limits<std::uint32_t>::max()) from.fail("leaves 32 bits");
    return static_cast<std::uint32_t>(value);
  }

  /// In ascending order: model and dictionary count alike.
  void add_node(const NodeDefinition& node, const NodeShape& shape) {
    if (static_cast<std::int64_t>(node.address) <= last_address_) throw Malformed("nodes must ascend by address");
    last_address_ = node.address;
    model_.add(node, shape);
  }

  void take_nodes(std::vector<NodeDefinition>& nodes) {
    std::uint32_t address = 0;
    std::int64_t predicted_children = 0;
    ByteReader& addresses = reader(Column::node_address);
    ByteReader& children = reader(Column::node_children);
    last_address_ = -1;
    for (NodeDefinition& node : nodes) {
      address = checked_u32(addresses, address + static_cast<std::int64_t>(addresses.varint(kU32)));
      node.address = address;
      node.child_base = checked_u32(children, predicted_children + unzigzag(children.varint(4 * kU32)));
      take_shape(node);
      const NodeShape& shape = model_.shape(node);
      predicted_children = static_cast<std::int64_t>(node.child_base + shape.units);
      add_node(node, shape);
    }
  }

  void take_tree(const Header& header, unsigned flags, std::vector<NodeDefinition>& nodes) {
    ByteReader& children = reader(Column::node_children);
    ByteReader& masks = reader(Column::node_tree);
    std::size_t next = 0;
    std::int64_t end = 0;
    links_.clear();
    const auto enter = [&](std::int64_t address, std::uint32_t parent, unsigned slot) {
      if (next == nodes.size()) masks.fail("names more nodes than there are");
      nodes[next].address = checked_u32(masks, address);
      const auto index = static_cast<std::uint32_t>(next++);
      walk_.push_back(index);
      links_.push_back({parent, slot});
      return index;
    };
    for (const unsigned root : {kNodesHoldRoot, kNodesHoldBlasRoot}) {
      if ((flags & root) == 0) continue;
      const bool first = root == kNodesHoldRoot;
      walk_.clear();
      enter(static_cast<std::int64_t>((first ? header.root : header.blas_root) / kNodeUnit),
            first ? GroupModel::kRootParent : GroupModel::kBlasRootParent, 0);
      bool skipped = true;
      while (!walk_.empty()) {
        const std::uint32_t index = walk_.back();
        walk_.pop_back();
        if (index == kSkipped) {
          skipped = true;
          continue;
        }
        NodeDefinition& node = nodes[index];
        const std::int64_t gap = skipped ? static_cast<std::int64_t>(children.varint(kU32)) : 0;
        skipped = false;
        node.child_base = checked_u32(children, end + gap);
        take_shape(node);
        const NodeShape& shape = model_.shape(node);
        if (shape.fault != nullptr) throw Malformed(shape.fault);
        end = static_cast<std::int64_t>(node.child_base) + shape.units;
        tree_order_.push_back(index);
        if (shape.internal_mask == 0) continue;
        const unsigned visited = masks.u8();
        if ((visited & ~unsigned{shape.internal_mask}) != 0) masks.fail("names a child that is not internal");
        tree_masks_[index] = static_cast<std::uint8_t>(visited);
        const std::size_t first_child = walk_.size();
        for (unsigned left = shape.internal_mask; left != 0; left &= left - 1) {
          const auto slot = static_cast<unsigned>(std::countr_zero(left));
          if ((visited >> slot & 1) == 0) {
            walk_.push_back(kSkipped);
            continue;
          }
          const unsigned offset = shape.offsets >> (4 * slot) & 0xF;
          enter(static_cast<std::int64_t>(node.child_base) + offset, GroupModel::kFirstNode + index, slot);
        }
        std::reverse(walk_.begin() + static_cast<std::ptrdiff_t>(first_child), walk_.end());
      }
    }
    if (next != nodes.size()) masks.fail("names fewer nodes than there are");
    last_address_ = -1;
    for (const NodeDefinition& node : nodes) add_node(node, model_.shape(node));
    for (std::uint32_t i = 0; i < nodes.size(); ++i) {
      model_[links_[i].parent].links[links_[i].slot] = GroupModel::kFirstNode + i;
    }
  }

  // In the order in which the other columns list the nodes.
  void take_first_hits() {
    ByteReader& hits = reader(Column::node_hits);
    for (std::uint32_t i = 0; i < nodes_->size(); ++i) {
      const std::uint32_t index = tree_order_.empty() ? i : tree_order_[i];
      NodeModel& node = model_[GroupModel::kFirstNode + index];
      node.last_hits = hits.u8() ^ tree_masks_[index];
      if (node.last_hits >> node.child_count != 0) hits.fail("names a child that is not there");
    }
  }

  void take_shape(NodeDefinition& node) {
    ByteReader& shapes = reader(Column::node_shape);
    const unsigned shape = shapes.u8();
    const unsigned leaf = shape >> 4 & 3;
    const bool mixed = (shape & kShapeMixed) != 0;
    const bool irregular = (shape & kShapeIrregular) != 0;
    node.child_count = shape & 0xF;
    if (node.child_count > kMaxWidth || (mixed && leaf == 0) || (irregular && (shape & 0x70) != 0)) {
      shapes.fail("holds an impossible node shape");
    }
    unsigned kinds = leaf * 0x5555;
    if (mixed) {
      const unsigned internal = reader(Column::node_kinds).u8();
      kinds &= ~(spread_bits(internal) * 3);
    } else if (irregular) {
      kinds = reader(Column::node_kinds).u8();
      kinds |= static_cast<unsigned>(reader(Column::node_kinds).u8()) << 8;
    }
    for (unsigned slot = 0; slot < node.child_count; ++slot) {
      node.child_kinds[slot] = kStoredKinds[kinds >> (2 * slot) & 3];
    }
  }

  // Bit i moves to bit 2 i.
  static unsigned spread_bits(unsigned byte) { return scatter_bits(byte, 0x5555); }

  void take_gaussians(std::uint64_t count) {
    ByteReader& ids = reader(Column::gaussian_id);
    gaussians_.clear();
    std::uint64_t last = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
      last += ids.varint(kMaxGaussian);
      if (last > kMaxGaussian) ids.fail("leaves 31 bits");
      gaussians_.push_back(static_cast<std::uint32_t>(last));
    }
    successor_.assign(gaussians_.size() + 1, kNoSuccessor);
  }

  void take_ray(Ray& ray, std::int64_t& pixel) {
    ByteReader& rays = reader(Column::ray);
    pixel = checked_u32(rays, pixel + unzigzag(rays.varint(4 * kU32)));
    ray.pixel = static_cast<std::uint32_t>(pixel);
    const std::uint64_t rounds = rays.varint(reader(Column::round_flags).remaining());
    ray.rounds.resize(static_cast<std::size_t>(rounds));
    ray.events.clear();
    ray.processed.clear();
    destination_.clear();
    std::uint64_t processed = 0;
    for (Round& round : ray.rounds) {
      take_round(round);
      processed += round.processed_count;
      const std::size_t first = ray.events.size();
      take_events(round, ray.events);
      const std::size_t count = ray.events.size() - first;
      if (count > kU32) throw Malformed("a round has 2^32 events or more");
      round.event_count = static_cast<std::uint32_t>(count);
    }
    take_processed(processed, ray.processed);
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
    round.eviction_dropped = 0;
    if (round.overflow) {
      round.eviction_dropped = static_cast<std::uint32_t>(reader(Column::eviction_dropped).varint(kU32));
    }
  }

  void take_events(const Round& round, std::vector<Event>& events) {
    source_.clear();
    if (round.replay) source_.swap(destination_);
    destination_.clear();
    frames_.clear();
    if (!round.replay) frames_.push_back({GroupModel::kRootParent, 0, 1});
    taken_ = 0;
    last_taken_ = -1;
    if (nearest_) read_.assign(source_.size(), false);
    while (true) {
      if (!frames_.empty()) {
        take_pop(events);
      } else if (taken_ < source_.size()) {
        take_replay(events);
      } else {
        break;
      }
    }
    if (round.overflow) destination_.clear();
  }

  static Event event_of(EventKind kind, std::uint32_t node, unsigned detail, unsigned checkpoints,
                        unsigned shifts = 0) {
    Event event;
    event.node = node;
    event.detail = static_cast<std::uint8_t>(detail);
    event.checkpoints = static_cast<std::uint8_t>(checkpoints);
    event.kind_shifts = Event::pack(kind, shifts);
    return event;
  }

  void take_replay(std::vector<Event>& events) {
    std::size_t index = taken_;
    if (lifo_) index = source_.size() - 1 - taken_;
    if (nearest_) {
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
    const NodeReference entry = source_[index];
    const std::uint32_t address = model_[entry.parent].child_address(entry.slot);
    ByteReader& ops = reader(Column::replay_op);
    const unsigned op = ops.u8();
    if (op > static_cast<unsigned>(ReplayOp::forward_checkpointed)) ops.fail("holds an unknown symbol");
    if (static_cast<ReplayOp>(op) == ReplayOp::take) {
      events.push_back(event_of(EventKind::replay_take, address, 0, 0));
      frames_.push_back({entry.parent, entry.context, 1U << entry.slot});
      if (model_.is_blas(address)) events.push_back(event_of(EventKind::visit_instance, entry.context, 1, 0));
      return;
    }
    const bool checkpointed = static_cast<ReplayOp>(op) == ReplayOp::forward_checkpointed;
    events.push_back(event_of(EventKind::replay_forward, address, 0, checkpointed ? 1 : 0));
    if (checkpointed) destination_.push_back(entry);
  }

  void take_pop(std::vector<Event>& events) {
    if (pops_left_-- == 0) throw Malformed("a group has more than 2^30 events");
    StackFrame& frame = frames_.back();
    NodeModel& parent = model_[frame.parent];
    const unsigned remaining = frame.remaining;
    unsigned slot = slot_order_ ? static_cast<unsigned>(std::countr_zero(remaining)) : parent.first_of(remaining);
    const unsigned inner = parent.internal_mask | parent.instance_mask;
    PopReader& pops = (inner >> slot & 1) != 0 ? inner_ : leaves_;
    const unsigned symbol = pops.next();
    const unsigned rank = symbol >> kPopRankShift & 7;
    if (rank != 0) {
      if (slot_order_ || rank >= bits_of_byte(remaining)) pops.fail("names a child that is not there");
      slot = parent.slot_at(remaining, rank);
      parent.move_up(remaining, slot);
    }
    const NodeReference popped{frame.parent, slot, frame.context};
    frame.remaining = remaining & ~(1U << slot);
    if (frame.remaining == 0) frames_.pop_back();
    const std::uint32_t address = parent.child_address(slot);
    const unsigned op = (symbol & kPopOp) ^ parent.last_op[slot];
    parent.last_op[slot] = static_cast<std::uint8_t>(op);
    const bool is_inner = (inner >> slot & 1) != 0;
    if (op > (is_inner ? static_cast<unsigned>(InnerOp::cull_checkpointed) : kLeafNearest)) {
      pops.fail("holds an unknown operation");
    }
    const bool changed_hits = (symbol & kPopHits) != 0;
    if (is_inner && op < static_cast<unsigned>(InnerOp::cull_dropped) && parent.is_internal(slot)) {
      return take_internal(popped, address, op == static_cast<unsigned>(InnerOp::visit_with_checkpoints), changed_hits,
                           events);
    }
    if (changed_hits) pops.fail("changes hits where none are");
    if (!is_inner) return take_leaf(popped, address, op, events);
    if (op >= static_cast<unsigned>(InnerOp::cull_dropped)) {
      return take_cull(popped, address, op == static_cast<unsigned>(InnerOp::cull_checkpointed), events);
    }
    if (op != static_cast<unsigned>(InnerOp::visit) || !two_level_) {
      pops.fail("holds an operation that an instance leaf cannot have");
    }
    events.push_back(event_of(EventKind::visit_instance, address, 0, 0));
    frames_.push_back({GroupModel::kBlasRootParent, address, 1});
  }

  void take_cull(const NodeReference& popped, std::uint32_t address, bool checkpointed, std::vector<Event>& events) {
    events.push_back(event_of(EventKind::cull, address, 0, checkpointed ? 1 : 0));
    if (checkpointed) destination_.push_back(popped);
  }

  /// Index into the model of the internal node in a child's place.
  std::uint32_t link(const NodeReference& child, std::uint32_t address) {
    std::uint32_t& link = model_[child.parent].links[child.slot];
    if (link == NodeModel::kUnknownLink) {
      const auto found = std::lower_bound(nodes_->begin(), nodes_->end(), address,
                                          [](const NodeDefinition& node, std::uint32_t a) { return node.address < a; });
      if (found == nodes_->end() || found->address != address) {
        throw Malformed("a visited internal node is missing in the dictionary");
      }
      link = GroupModel::kFirstNode + static_cast<std::uint32_t>(found - nodes_->begin());
    }
    return link;
  }

  void take_internal(const NodeReference& popped, std::uint32_t address, bool checkpoints_some, bool changed_hits,
                     std::vector<Event>& events) {
    const std::uint32_t index = link(popped, address);
    NodeModel& node = model_[index];
    if (changed_hits) {
      const unsigned difference = reader(Column::hits).u8();
      if (difference == 0) reader(Column::hits).fail("changes nothing");
      if (difference >> node.child_count != 0) reader(Column::hits).fail("names a child that is not there");
      node.last_hits = static_cast<std::uint8_t>(node.last_hits ^ difference);
    }
    const unsigned hits = node.last_hits;
    unsigned checkpoints = 0;
    if (checkpoints_some) {
      if (hits == 0) throw Malformed("a visit checkpoints children where none is hit");
      checkpoints = hits;
      if (!has_one_bit(hits)) {
        const unsigned gathered = reader(Column::checkpoints).u8();
        if (gathered == 0 || gathered >> bits_of_byte(hits) != 0) {
          reader(Column::checkpoints).fail("names a child that is not hit");
        }
        checkpoints = scatter_bits(gathered, hits);
      }
      for (unsigned left = checkpoints; left != 0; left &= left - 1) {
        destination_.push_back({index, static_cast<std::uint32_t>(std::countr_zero(left)), popped.context});
      }
    }
    const unsigned pushed = hits & ~checkpoints;
    if (pushed != 0) frames_.push_back({index, popped.context, pushed});
    events.push_back(event_of(EventKind::visit_internal, index - GroupModel::kFirstNode, pushed, checkpoints));
  }

  void take_leaf(const NodeReference& popped, std::uint32_t address, unsigned op, std::vector<Event>& events) {
    if (op == kLeafCullDropped || op == kLeafCullCheckpointed)
      return take_cull(popped, address, op == kLeafCullCheckpointed, events);
    const bool checkpointed = op == kLeafBeyondCheckpointed;
    LeafOutcome outcome = checkpointed ? LeafOutcome::beyond : static_cast<LeafOutcome>(op);
    if (op == kLeafNearest) outcome = LeafOutcome::nearest;
    unsigned shifts = 0;
    if (outcome == LeafOutcome::inserted || outcome == LeafOutcome::displaced) {
      shifts = static_cast<unsigned>(reader(Column::shifts).varint(kMaxShifts));
    }
    if (checkpointed) destination_.push_back(popped);
    events.push_back(
        event_of(EventKind::visit_leaf, address, static_cast<unsigned>(outcome), checkpointed ? 1 : 0, shifts));
  }

  void take_processed(std::uint64_t count, std::vector<Processed>& processed) {
    ByteReader& symbols = reader(Column::processed);
    if (count > symbols.remaining()) symbols.fail("ends too early");
    std::size_t last = gaussians_.size();
    for (std::uint64_t i = 0; i < count; ++i) {
      const unsigned symbol = symbols.u8();
      if (symbol > (kProcessedBlended | kProcessedNotPredicted)) symbols.fail("holds an unknown symbol");
      std::uint64_t index = successor_[last];
      if ((symbol & kProcessedNotPredicted) != 0) {
        index = reader(Column::gaussian_low).u8();
        index |= reader(Column::gaussian_high).varint(kU32) << 8;
      }
      if (index >= gaussians_.size()) symbols.fail("names a Gaussian that is not listed");
      successor_[last] = static_cast<std::uint32_t>(index);
      last = static_cast<std::size_t>(index);
      Processed entry;
      entry.gaussian = gaussians_[last] & 0x7FFFFFFFU;
      entry.blended = symbol & kProcessedBlended;
      processed.push_back(entry);
    }
  }

  static constexpr std::uint64_t kU32 = std::numeric_limits<std::uint32_t>::max();
  static constexpr std::uint64_t kU16 = std::numeric_limits<std::uint16_t>::max();
  static constexpr std::uint64_t kMaxGaussian = (1ULL << 31) - 1;

  bool nearest_ = false;
  bool lifo_ = false;
  bool slot_order_ = false;
  bool two_level_ = false;
  ColumnSet columns_;
  std::array<ByteReader, kColumnCount> readers_;
  GroupModel model_;
  static constexpr std::uint32_t kSkipped = 0xFFFFFFFF;
  struct Place {
    std::uint32_t parent = 0;  ///< index into the model
    unsigned slot = 0;
  };
  PopReader inner_;
  PopReader leaves_;
  std::uint64_t pops_left_ = 0;
  const std::vector<NodeDefinition>* nodes_ = nullptr;
  std::int64_t last_address_ = -1;
  std::vector<std::uint8_t> tree_masks_;   ///< children in the dictionary, of a tree
  std::vector<std::uint32_t> tree_order_;  ///< of a tree: its nodes in the order of the columns
  std::vector<Place> links_;               ///< of a tree: where each node hangs
  std::vector<std::uint32_t> walk_;
  std::vector<StackFrame> frames_;
  std::vector<NodeReference> source_;
  std::vector<NodeReference> destination_;
  std::size_t taken_ = 0;         ///< source entries read in this round
  std::int64_t last_taken_ = -1;  ///< position of the one read last
  std::vector<bool> read_;        ///< nearest order: entries already read
  std::vector<std::uint32_t> gaussians_;
  std::vector<std::uint32_t> successor_;
};

}  // namespace

void decode_group(const Header& header, const std::uint8_t* payload, std::size_t size, std::uint64_t index,
                  RayGroup& group) {
  // On the heap: members of a thread_local object would each be reached through the thread pointer.
  thread_local const std::unique_ptr<GroupDecoder> decoder = std::make_unique<GroupDecoder>();
  decoder->decode(header, payload, size, index, group);
}

}  // namespace grtx::traces
