// Encodes what the rays of a group do, as they do it: each pop of a stack as the operation on a child of a known node.
// Who calls it keeps the stack and the checkpoint buffers, in places (ChildPlace).
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "grtx/traces/codec/byte_stream.h"
#include "grtx/traces/codec/columns.h"
#include "grtx/traces/codec/count_totals.h"
#include "grtx/traces/codec/dictionary_encoder.h"
#include "grtx/traces/codec/encoded_group.h"
#include "grtx/traces/codec/group_codec.h"
#include "grtx/traces/codec/group_model.h"
#include "grtx/traces/codec/group_place.h"
#include "grtx/traces/codec/node_source.h"
#include "grtx/traces/codec/processed_coder.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::traces {

/// A child of a node of the group's model, on a stack or in a checkpoint buffer; on a stack also how its pop differs
/// from the expected one.
class ChildPlace {
 public:
  static constexpr std::uint32_t kMaxNodes = 1U << 25;

  ChildPlace() = default;
  ChildPlace(std::uint32_t parent, unsigned slot) : packed_(parent << 7 | slot << 4) {}
  /// rank: siblings on the stack that are expected before it. crosses: a leaf where none is expected, or the reverse.
  ChildPlace(std::uint32_t parent, unsigned slot, unsigned rank, unsigned crosses)
      : packed_(parent << 7 | slot << 4 | rank << 1 | crosses) {}

  std::uint32_t parent() const { return packed_ >> 7; }
  unsigned slot() const { return packed_ >> 4 & 7; }
  unsigned rank() const { return packed_ >> 1 & 7; }
  unsigned crosses() const { return packed_ & 1; }

 private:
  std::uint32_t packed_ = 0;
};

/// One group at a time, one encoder a thread; keeps its memory. Trusts its caller: the operations must be those of a
/// traversal. What breaks a limit of the format throws std::logic_error.
class PopEncoder {
 public:
  PopEncoder() = default;
  PopEncoder(const PopEncoder&) = delete;
  PopEncoder& operator=(const PopEncoder&) = delete;

  /// Begins a group whose root is of kind `root`. Header and nodes must live until finish().
  void begin(const Header& header, std::uint32_t index, RayKind kind, NodeKind root, const NodeSource& nodes);
  /// All nodes of the group, ascending by address, before its first ray: none is asked of the NodeSource.
  void list(const std::vector<NodeDefinition>& nodes) { dictionary_.list(nodes); }
  /// Replaces `group`.
  void finish(EncodedGroup& group);

  /// The next ray in lane order.
  void begin_ray();
  void end_ray(std::uint32_t pixel, std::size_t rounds, std::span<const Processed> processed);
  void begin_round() { counts_ = RoundCounts{}; }
  void end_round(const Round& round);

  /// Room for so many more pops and source entries. Nothing below checks.
  void reserve(std::size_t pops);

  /// The pop of a leaf that was visited. checkpoints: 1 when it was checkpointed.
  void leaf(ChildPlace at, LeafOutcome outcome, unsigned checkpoints, unsigned shifts) {
    static constexpr std::uint8_t kOps[8] = {0, 1, 2, 3, 4, 5, 6, kLeafNearest};
    const auto kind = static_cast<unsigned>(outcome);
    unsigned op = kOps[kind];
    if (checkpoints != 0) op = kLeafBeyondCheckpointed;
    ++counts_.leaves[kind];
    counts_.written += checkpoints;
    put(at, op, 0, kLeaves);
    if (outcome == LeafOutcome::inserted || outcome == LeafOutcome::displaced) {
      columns_.put_varint(Column::shifts, shifts);
    }
  }
  /// The pop of an instance leaf that was visited.
  void instance(ChildPlace at) {
    ++counts_.instances;
    put(at, static_cast<unsigned>(InnerOp::visit), 0, kInner);
  }
  /// The visit of an instance leaf for a node taken from a checkpoint buffer: it pops nothing.
  void instance_of_taken() { ++counts_.instances; }
  void cull(ChildPlace at, unsigned checkpoints) {
    const NodeModel& parent = model_[at.parent()];
    const unsigned inner = (parent.internal_mask | parent.instance_mask) >> at.slot() & 1;
    ++counts_.culls;
    counts_.written += checkpoints;
    const unsigned op = inner != 0 ? static_cast<unsigned>(InnerOp::cull_dropped) : kLeafCullDropped;
    put(at, op + checkpoints, 0, inner != 0 ? kInner : kLeaves);
  }
  /// Index into the model of the internal node at `address` (in units), which is there; internal() comes next.
  std::uint32_t reach(ChildPlace at, std::uint32_t address) {
    const std::uint32_t index = model_[at.parent()].links[at.slot()];
    return index != NodeModel::kUnknownLink ? index : reach_first(at, address);
  }
  /// The pop of an internal node that was visited, with the children pushed and those checkpointed.
  void internal(ChildPlace at, std::uint32_t index, unsigned pushed, unsigned checkpoints) {
    const unsigned hits = pushed | checkpoints;
    if (reached_) {
      reached_ = false;
      dictionary_.visit_first(index, hits);
    }
    NodeModel& node = model_[index];
    const unsigned changed = hits ^ node.last_hits;
    node.last_hits = static_cast<std::uint8_t>(hits);
    std::uint8_t*& hits_end = columns_.end(Column::hits);
    *hits_end = static_cast<std::uint8_t>(changed);
    hits_end += changed != 0 ? 1 : 0;
    ++counts_.internal;
    InnerOp op = InnerOp::visit;
    if (checkpoints != 0) {
      op = InnerOp::visit_with_checkpoints;
      counts_.written += bits_of_byte(checkpoints);
      // A single hit needs no mask: it is the one that is checkpointed.
      if (!has_one_bit(hits)) columns_.put(Column::checkpoints, gather_bits(checkpoints, hits));
    }
    put(at, static_cast<unsigned>(op), changed != 0 ? kPopHits : 0, kInner);
  }
  /// Source entries, which are read while the stack is empty.
  void take() { read(ReplayOp::take); }
  void forward(unsigned checkpoints) {
    counts_.written += checkpoints;
    read(checkpoints != 0 ? ReplayOp::forward_checkpointed : ReplayOp::forward_dropped);
  }
  /// The round ends, although it might have read more from its bins.
  void stop() { columns_.put(Column::replay_op, static_cast<unsigned>(ReplayOp::stop)); }
  /// In front of a replay's events; takes the room of one.
  void bin_order(const BinOrder& order) {
    bin(order.first);
    bin(order.before_far);
  }
  /// The bin of an entry written.
  void bin(unsigned bin) { columns_.put(Column::bin, bin); }
  /// In nearest order: the entry's position against that behind the one read last.
  void source_position(std::int64_t difference) { columns_.put_varint(Column::replay_entry, zigzag(difference)); }

  /// The order in which a node's children are expected to be popped (NodeModel::order).
  std::uint64_t order(std::uint32_t index) const { return model_[index].order; }
  /// The child that is popped first of `remaining`, which may be another than the expected one: learns from it.
  ChildPlace pop(std::uint32_t parent, unsigned remaining, unsigned slot) {
    NodeModel& node = model_[parent];
    const unsigned first = NodeModel::first_of(node.ordered(remaining));
    if (first == slot) return {parent, slot};
    const unsigned inner = node.internal_mask | node.instance_mask;
    const ChildPlace place(parent, slot, node.rank_of(remaining, slot), (inner >> slot ^ inner >> first) & 1);
    node.move_up(remaining, slot);
    return place;
  }
  /// The same for all children of a node that are pushed, the last of `stack` being popped first.
  void pop_all(std::span<ChildPlace> stack);

  const GroupModel& model() const { return model_; }
  GroupPlace& place() { return place_; }

 private:
  static constexpr unsigned kLeaves = 0, kInner = 1;

  struct Symbols {
    Bytes bytes;
    std::uint8_t* end = nullptr;
  };

  /// To the symbols of the kind of child that was expected.
  void put(ChildPlace at, unsigned op, unsigned changed_hits, unsigned kind) {
    std::uint8_t& last = model_[at.parent()].last_op[at.slot()];
    const unsigned symbol = (op ^ last) | at.rank() << kPopRankShift | changed_hits;
    last = static_cast<std::uint8_t>(op);
    *symbols_[kind ^ at.crosses()].end++ = static_cast<std::uint8_t>(symbol);
  }
  void read(ReplayOp op) {
    ++counts_.read;
    columns_.put(Column::replay_op, static_cast<unsigned>(op));
  }
  std::uint32_t reach_first(ChildPlace at, std::uint32_t address);
  void put_pops(Column gaps, Column symbols, Symbols& pops, unsigned& run);
  void end_gap(Column column, unsigned run);

  const Header* header_ = nullptr;
  RayKind kind_ = RayKind::primary;
  NodeKind root_ = NodeKind::internal;
  bool nearest_ = false;
  bool bins_ = false;
  bool reached_ = false;  ///< by the visit under way, for the first time
  std::int64_t last_pixel_ = 0;
  std::size_t rays_ = 0;
  std::uint64_t events_ = 0;
  std::uint64_t in_eviction_buffer_ = 0;
  GroupPlace place_;
  Totals totals_;
  RoundCounts counts_;
  ColumnWriter columns_;
  std::array<Symbols, 2> symbols_;         ///< of the ray's pops, the predicted ones as well
  unsigned inner_run_ = 0, leaf_run_ = 0;  ///< predicted pops since the last other one
  GroupModel model_;
  DictionaryEncoder dictionary_{model_, place_};
  ProcessedEncoder processed_;
};

}  // namespace grtx::traces
