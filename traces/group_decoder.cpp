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
    if (flags == 0) {
      take_nodes(header, group.nodes);
    } else {
      take_tree(header, flags, group.nodes);
    }
    try {
      model_.build(header, group.nodes, root);
    } catch (const std::invalid_argument& fault) {
      throw Malformed(fault.what());
    }
    model_.prepare_links();
    for (std::uint32_t i = 0; i < group.nodes.size(); ++i) model_[i].last_hits = tree_masks_[i];
    take_gaussians(gaussians);
    group.rays.resize(static_cast<std::size_t>(rays));
    std::int64_t pixel = 0;
    for (Ray& ray : group.rays) take_ray(ray, pixel);
    for (const ByteReader& column : readers_) column.expect_end();
  }

 private:
  ByteReader& reader(Column column) { return readers_[static_cast<std::size_t>(column)]; }

  static std::uint32_t checked_u32(const ByteReader& from, std::int64_t value) {
    if (value < 0 || value > std::numeric_limits<std::uint32_t>::max()) from.fail("leaves 32 bits");
    return static_cast<std::uint32_t>(value);
  }

  void take_nodes(const Header& header, std::vector<NodeDefinition>& nodes) {
    std::uint32_t address = 0;
    std::int64_t predicted_children = 0;
    ByteReader& addresses = reader(Column::node_address);
    ByteReader& children = reader(Column::node_children);
    for (NodeDefinition& node : nodes) {
      address = checked_u32(addresses, address + static_cast<std::int64_t>(addresses.varint(kU32)));
      node.address = address;
      node.child_base = checked_u32(children, predicted_children + unzigzag(children.varint(4 * kU32)));
      take_shape(node);
      predicted_children = static_cast<std::int64_t>(node.child_base + model_.shape(header, node).units);
    }
  }

  void take_tree(const Header& header, unsigned flags, std::vector<NodeDefinition>& nodes) {
    ByteReader& children = reader(Column::node_children);
    ByteReader& masks = reader(Column::node_tree);
    std::size_t next = 0;
    std::int64_t end = 0;
    const auto enter = [&](std::int64_t address) {
      if (next == nodes.size()) masks.fail("names more nodes than there are");
      nodes[next].address = checked_u32(masks, address);
      walk_.push_back(static_cast<std::uint32_t>(next++));
    };
    for (const unsigned root : {kNodesHoldRoot, kNodesHoldBlasRoot}) {
      if ((flags & root) == 0) continue;
      walk_.clear();
      enter(static_cast<std::int64_t>((root == kNodesHoldRoot ? header.root : header.blas_root) / kNodeUnit));
      while (!walk_.empty()) {
        const std::uint32_t index = walk_.back();
        NodeDefinition& node = nodes[index];
        walk_.pop_back();
        node.child_base = checked_u32(children, end + static_cast<std::int64_t>(children.varint(kU32)));
        take_shape(node);
        const NodeShape& shape = model_.shape(header, node);
        if (shape.fault != nullptr) throw Malformed(shape.fault);
        end = static_cast<std::int64_t>(node.child_base) + shape.units;
        if (shape.internal_mask == 0) continue;
        const unsigned visited = masks.u8();
        if ((visited & ~unsigned{shape.internal_mask}) != 0) masks.fail("names a child that is not internal");
        tree_masks_[index] = static_cast<std::uint8_t>(visited);
        const std::size_t first = walk_.size();
        for (unsigned left = visited; left != 0; left &= left - 1) {
          const unsigned offset = shape.offsets >> (4 * static_cast<unsigned>(std::countr_zero(left))) & 0xF;
          enter(static_cast<std::int64_t>(node.child_base) + offset);
        }
        std::reverse(walk_.begin() + static_cast<std::ptrdiff_t>(first), walk_.end());
      }
    }
    if (next != nodes.size()) masks.fail("names fewer nodes than there are");
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
    if (!round.replay) frames_.push_back({model_.root_parent(), 0, 1});
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
    StackFrame& frame = frames_.back();
    NodeModel& parent = model_[frame.parent];
    unsigned slot = static_cast<unsigned>(std::countr_zero(frame.remaining));
    if (!slot_order_ && !has_one_bit(frame.remaining)) {
      ByteReader& picks = reader(Column::pick);
      const unsigned rank = picks.u8();
      if (rank >= bits_of_byte(frame.remaining)) picks.fail("names a child that is not there");
      slot = parent.slot_at(frame.remaining, rank);
    }
    const NodeReference popped{frame.parent, slot, frame.context};
    frame.remaining &= ~(1U << slot);
    if (frame.remaining == 0) frames_.pop_back();
    const std::uint32_t address = parent.child_address(slot);
    if (parent.is_internal(slot)) {
      take_internal(popped, address, events);
    } else if (parent.is_instance(slot)) {
      take_instance(popped, address, events);
    } else {
      take_leaf(popped, address, events);
    }
  }

  unsigned take_op(Column column, const NodeReference& popped, unsigned limit) {
    std::uint8_t& last = model_[popped.parent].last_op[popped.slot];
    const unsigned op = reader(column).u8() ^ last;
    if (op > limit) reader(column).fail("holds an unknown symbol");
    last = static_cast<std::uint8_t>(op);
    return op;
  }

  void take_cull(const NodeReference& popped, std::uint32_t address, bool checkpointed, std::vector<Event>& events) {
    events.push_back(event_of(EventKind::cull, address, 0, checkpointed ? 1 : 0));
    if (checkpointed) destination_.push_back(popped);
  }

  void take_internal(const NodeReference& popped, std::uint32_t address, std::vector<Event>& events) {
    const auto op =
        static_cast<InnerOp>(take_op(Column::inner_op, popped, static_cast<unsigned>(InnerOp::cull_checkpointed)));
    if (op >= InnerOp::cull_dropped) return take_cull(popped, address, op == InnerOp::cull_checkpointed, events);
    const std::uint32_t index = model_.link(popped.parent, popped.slot);
    if (index == GroupModel::kUnknownLink) throw Malformed("a visited internal node is missing in the dictionary");
    NodeModel& node = model_[index];
    const unsigned hits = reader(Column::hits).u8() ^ node.last_hits;
    if (hits >> node.child_count != 0) reader(Column::hits).fail("names a child that is not there");
    node.last_hits = static_cast<std::uint8_t>(hits);
    unsigned checkpoints = 0;
    if (op == InnerOp::visit_with_checkpoints) {
      if (hits == 0) reader(Column::inner_op).fail("checkpoints children where none is hit");
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
    events.push_back(event_of(EventKind::visit_internal, index, pushed, checkpoints));
  }

  void take_instance(const NodeReference& popped, std::uint32_t address, std::vector<Event>& events) {
    const auto op =
        static_cast<InnerOp>(take_op(Column::inner_op, popped, static_cast<unsigned>(InnerOp::cull_checkpointed)));
    if (op >= InnerOp::cull_dropped) return take_cull(popped, address, op == InnerOp::cull_checkpointed, events);
    if (op != InnerOp::visit || !two_level_)
      reader(Column::inner_op).fail("holds a symbol that an instance leaf cannot have");
    events.push_back(event_of(EventKind::visit_instance, address, 0, 0));
    frames_.push_back({model_.blas_root_parent(), address, 1});
  }

  void take_leaf(const NodeReference& popped, std::uint32_t address, std::vector<Event>& events) {
    const unsigned op = take_op(Column::leaf_op, popped, kLeafNearest);
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
  std::vector<std::uint8_t> tree_masks_;  ///< children in the dictionary, of a tree
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
