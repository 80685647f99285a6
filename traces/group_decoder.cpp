#include <algorithm>
#include <bit>
#include <limits>
#include <memory>
#include <vector>

#include "traces/columns.h"
#include "traces/dictionary_decoder.h"
#include "traces/group_codec.h"
#include "traces/group_model.h"
#include "traces/predicted_pops.h"
#include "traces/processed_coder.h"

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
    group.nodes.assign(static_cast<std::size_t>(nodes), NodeDefinition{});
    nodes_ = &group.nodes;
    model_.begin(header, root);
    dictionary_.take(header, flags, group.nodes);
    inner_.begin(reader(Column::inner_gap), reader(Column::inner));
    leaves_.begin(reader(Column::leaf_gap), reader(Column::leaf));
    pops_left_ = kMaxPops;
    processed_.begin(gaussians, readers_);
    group.rays.resize(static_cast<std::size_t>(rays));
    std::int64_t pixel = 0;
    for (Ray& ray : group.rays) take_ray(ray, pixel);
    inner_.expect_end();
    leaves_.expect_end();
    for (const Column column : {Column::inner_gap, Column::inner, Column::leaf_gap, Column::leaf}) {
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

  static constexpr std::uint64_t kU32 = std::numeric_limits<std::uint32_t>::max();
  static constexpr std::uint64_t kU16 = std::numeric_limits<std::uint16_t>::max();

  bool nearest_ = false;
  bool lifo_ = false;
  bool slot_order_ = false;
  bool two_level_ = false;
  ColumnSet columns_;
  ColumnReaders readers_;
  GroupModel model_;
  DictionaryDecoder dictionary_{readers_, model_};
  ProcessedDecoder processed_;
  PopReader inner_;
  PopReader leaves_;
  std::uint64_t pops_left_ = 0;
  const std::vector<NodeDefinition>* nodes_ = nullptr;
  std::vector<StackFrame> frames_;
  std::vector<NodeReference> source_;
  std::vector<NodeReference> destination_;
  std::size_t taken_ = 0;         ///< source entries read in this round
  std::int64_t last_taken_ = -1;  ///< position of the one read last
  std::vector<bool> read_;        ///< nearest order: entries already read
};

}  // namespace

void decode_group(const Header& header, const std::uint8_t* payload, std::size_t size, std::uint64_t index,
                  RayGroup& group) {
  // On the heap: members of a thread_local object would each be reached through the thread pointer.
  thread_local const std::unique_ptr<GroupDecoder> decoder = std::make_unique<GroupDecoder>();
  decoder->decode(header, payload, size, index, group);
}

}  // namespace grtx::traces
