#include <algorithm>
#include <bit>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "traces/columns.h"
#include "traces/file_layout.h"
#include "traces/group_codec.h"
#include "traces/group_model.h"
#include "traces/source_assignment.h"

namespace grtx::traces {
namespace {

class GroupEncoder {
 public:
  void encode(const Header& header, const RayGroup& group, Bytes& out) {
    header_ = &header;
    group_ = &group;
    lane_ = round_ = event_ = kNowhere;
    nearest_ = header.checkpoint_order == "nearest";
    lifo_ = header.checkpoint_order == "lifo";
    slot_order_ = header.child_order == "slot";
    columns_.clear();
    require(group.index < header.groups, "the index must be below the header's groups");
    require(group.rays.size() <= header.warp_size, "a group holds at most warp_size rays");
    require(group.kind <= RayKind::mirror, "the ray kind must be known");
    const NodeKind root = root_kind();
    try {
      model_.build(header, group.nodes, root);
    } catch (const std::invalid_argument& fault) {
      fail(fault.what());
    }
    Bytes& top = columns_[Column::group];
    put_varint(top, group.index);
    top.push_back(static_cast<std::uint8_t>(group.kind));
    top.push_back(static_cast<std::uint8_t>(root));
    put_varint(top, group.nodes.size());
    put_varint(top, group.rays.size());
    put_nodes();
    collect_gaussians();
    put_varint(top, gaussians_.size());
    std::int64_t last_pixel = 0;
    for (lane_ = 0; lane_ < group.rays.size(); ++lane_) {
      const Ray& ray = group.rays[lane_];
      put_varint(columns_[Column::ray], zigzag(static_cast<std::int64_t>(ray.pixel) - last_pixel));
      put_varint(columns_[Column::ray], ray.rounds.size());
      last_pixel = ray.pixel;
      put_ray(ray);
    }
    if (columns_.bytes() > kMaxGroupBytes) {
      lane_ = kNowhere;
      fail("takes more than 1 GiB before compression");
    }
    pack_columns(columns_, out);
  }

 private:
  static constexpr std::size_t kNowhere = ~std::size_t{0};

  [[noreturn]] void fail(const std::string& rule) const {
    std::string place = "trace group " + std::to_string(group_->index);
    if (lane_ != kNowhere) place += " lane " + std::to_string(lane_);
    if (round_ != kNowhere) place += " round " + std::to_string(round_);
    if (event_ != kNowhere) place += " event " + std::to_string(event_);
    throw std::logic_error(place + ": " + rule);
  }
  void require(bool holds, const char* rule) const {
    if (!holds) fail(rule);
  }
  void put(Column column, unsigned symbol) { columns_[column].push_back(static_cast<std::uint8_t>(symbol)); }

  // The first event of a round from the root tells what the root is; a root that is only culled may pass as internal.
  NodeKind root_kind() const {
    for (const Ray& ray : group_->rays) {
      std::size_t first = 0;
      for (const Round& round : ray.rounds) {
        if (!round.replay && round.event_count > 0 && first < ray.events.size()) {
          const EventKind kind = ray.events[first].kind();
          if (kind == EventKind::visit_internal) return NodeKind::internal;
          if (kind == EventKind::visit_instance) return NodeKind::instance;
          if (kind == EventKind::visit_leaf) return NodeKind::triangle;
        }
        first += round.event_count;
      }
    }
    return NodeKind::internal;
  }

  void put_nodes() {
    std::int64_t last_address = 0;
    std::int64_t predicted_children = 0;
    for (const NodeDefinition& node : group_->nodes) {
      put_varint(columns_[Column::node_address], static_cast<std::uint64_t>(node.address - last_address));
      last_address = node.address;
      // Builders that place children level by level or subtree by subtree put them right behind the ones before.
      put_varint(columns_[Column::node_children],
                 zigzag(static_cast<std::int64_t>(node.child_base) - predicted_children));
      predicted_children =
          static_cast<std::int64_t>(node.child_base + children_bytes(node, header_->bvh_width) / kNodeUnit);
      put_shape(node);
    }
  }

  // Nodes mostly have leaves of one kind: their kind, and a mask of the internal children if there are both.
  void put_shape(const NodeDefinition& node) {
    unsigned internal = 0;
    unsigned leaf = 0;
    unsigned kinds = 0;
    bool irregular = false;
    for (unsigned slot = 0; slot < node.child_count; ++slot) {
      const unsigned kind = stored_kind(node.child_kinds[slot]);
      kinds |= kind << (2 * slot);
      if (kind == 0) {
        internal |= 1U << slot;
      } else {
        irregular = irregular || (leaf != 0 && leaf != kind);
        leaf = kind;
      }
    }
    const bool mixed = leaf != 0 && internal != 0 && !irregular;
    put(Column::node_shape,
        node.child_count | (irregular ? 0 : leaf) << 4 | (mixed ? kShapeMixed : 0) | (irregular ? kShapeIrregular : 0));
    if (mixed) put(Column::node_kinds, internal);
    if (irregular) {
      put(Column::node_kinds, kinds & 0xFF);
      put(Column::node_kinds, kinds >> 8);
    }
  }

  static unsigned stored_kind(NodeKind kind) {
    unsigned code = 0;
    while (kStoredKinds[code] != kind) ++code;  // GroupModel::build has refused unknown kinds
    return code;
  }

  void collect_gaussians() {
    gaussians_.clear();
    for (const Ray& ray : group_->rays) {
      for (const Processed& entry : ray.processed) gaussians_.push_back(entry.gaussian);
    }
    std::sort(gaussians_.begin(), gaussians_.end());
    gaussians_.erase(std::unique(gaussians_.begin(), gaussians_.end()), gaussians_.end());
    std::uint32_t last = 0;
    for (const std::uint32_t gaussian : gaussians_) {
      put_varint(columns_[Column::gaussian_id], gaussian - last);
      last = gaussian;
    }
    successor_.assign(gaussians_.size() + 1, kNoSuccessor);
  }

  void put_ray(const Ray& ray) {
    destination_.clear();
    std::size_t next_event = 0;
    std::size_t processed = 0;
    for (round_ = 0; round_ < ray.rounds.size(); ++round_) {
      const Round& round = ray.rounds[round_];
      require(round.event_count <= ray.events.size() - next_event, "event_count exceeds the ray's events");
      require(round.processed_count <= ray.processed.size() - processed, "processed_count exceeds the ray's entries");
      require(round.overflow || round.eviction_dropped == 0, "evictions are only dropped by an overflow");
      put(Column::round_flags, (round.replay ? kRoundReplay : 0) | (round.overflow ? kRoundOverflow : 0) |
                                   (round.terminated ? kRoundTerminated : 0));
      put_varint(columns_[Column::preloaded], round.preloaded);
      put_varint(columns_[Column::k_count], round.k_count);
      put_varint(columns_[Column::processed_count],
                 zigzag(static_cast<std::int64_t>(round.k_count) - round.processed_count));
      if (round.overflow) put_varint(columns_[Column::eviction_dropped], round.eviction_dropped);
      put_events(ray, round, next_event);
      event_ = kNowhere;
      next_event += round.event_count;
      processed += round.processed_count;
    }
    round_ = kNowhere;
    require(next_event == ray.events.size(), "events remain behind the last round");
    require(processed == ray.processed.size(), "processed entries remain behind the last round");
    put_processed(ray);
  }

  void put_events(const Ray& ray, const Round& round, std::size_t first) {
    source_.clear();
    if (round.replay) source_.swap(destination_);
    destination_.clear();
    frames_.clear();
    if (!round.replay) frames_.push_back({model_.root_parent(), 0, 1});
    taken_ = 0;
    last_taken_ = -1;
    const std::span<const Event> events(ray.events.data() + first, round.event_count);
    if (nearest_ && round.replay) assigned_ = &assignment_.assign(model_, source_, events);
    for (event_ = 0; event_ < round.event_count; ++event_) {
      const Event& event = events[event_];
      if (!frames_.empty()) {
        put_pop(event);
        continue;
      }
      const bool more = event_ + 1 < events.size();
      if (put_replay(event) && model_.is_blas(event.node)) {
        require(more, "visit_instance must follow the take of a BLAS node");
        ++event_;
        const Event& transform = events[event_];
        require(transform.kind() == EventKind::visit_instance && transform.detail == 1 &&
                    transform.node == frames_.back().context && transform.checkpoints == 0 && transform.shifts() == 0,
                "must be the visit of the instance leaf through which the taken BLAS node was reached (detail 1)");
      }
    }
    require(frames_.empty(), "the stack must be empty at the end of a round");
    require(taken_ == source_.size(), "every source entry must be read");
    if (round.overflow) destination_.clear();
  }

  // Returns whether the entry was pushed.
  bool put_replay(const Event& event) {
    const bool take = event.kind() == EventKind::replay_take;
    require(take || event.kind() == EventKind::replay_forward, "the stack is empty: only a source entry can come next");
    require(taken_ < source_.size(), "no source entry is left to read");
    std::size_t index = taken_;
    if (lifo_) index = source_.size() - 1 - taken_;
    if (nearest_) {
      require((*assigned_)[taken_] != SourceAssignment::kNone, "no unread source entry has this address");
      index = (*assigned_)[taken_];
      put_varint(columns_[Column::replay_entry], zigzag(static_cast<std::int64_t>(index) - last_taken_ - 1));
      last_taken_ = static_cast<std::int64_t>(index);
    }
    ++taken_;
    const NodeReference entry = source_[index];
    require(event.node == model_[entry.parent].child_address(entry.slot), "must read the next source entry");
    require(event.detail == 0 && event.shifts() == 0, "a replay event has no detail and no shifts");
    require(event.checkpoints <= (take ? 0 : 1), "a forward writes at most one checkpoint, a take none");
    if (take) {
      put(Column::replay_op, static_cast<unsigned>(ReplayOp::take));
      frames_.push_back({entry.parent, entry.context, 1U << entry.slot});
      return true;
    }
    put(Column::replay_op,
        static_cast<unsigned>(event.checkpoints != 0 ? ReplayOp::forward_checkpointed : ReplayOp::forward_dropped));
    if (event.checkpoints != 0) destination_.push_back(entry);
    return false;
  }

  void put_pop(const Event& event) {
    StackFrame& frame = frames_.back();
    NodeModel& parent = model_[frame.parent];
    const bool internal_event = event.kind() == EventKind::visit_internal;
    if (internal_event) require(event.node < group_->nodes.size(), "the node index exceeds the dictionary");
    const std::uint32_t address = internal_event ? group_->nodes[event.node].address : event.node;
    const unsigned slot = slot_of(parent, frame.remaining, address);
    if (std::has_single_bit(frame.remaining)) {
      // no choice
    } else if (slot_order_) {
      require(slot == static_cast<unsigned>(std::countr_zero(frame.remaining)),
              "children must be popped in slot order");
    } else {
      put(Column::pick, parent.rank_of(frame.remaining, slot));
    }
    const NodeReference popped{frame.parent, slot, frame.context};
    frame.remaining &= ~(1U << slot);
    if (frame.remaining == 0) frames_.pop_back();
    if (event.kind() == EventKind::cull) {
      require(event.detail == 0 && event.shifts() == 0, "a cull has no detail and no shifts");
      require(event.checkpoints <= 1, "a cull writes at most one checkpoint");
    }
    if (parent.is_internal(slot)) {
      put_internal(event, popped);
    } else if (parent.is_instance(slot)) {
      put_instance(event, popped);
    } else {
      put_leaf(event, popped);
    }
  }

  unsigned slot_of(const NodeModel& parent, std::uint32_t remaining, std::uint32_t address) const {
    const std::uint32_t offset = address - parent.child_base;
    for (std::uint32_t left = remaining; left != 0; left &= left - 1) {
      const unsigned slot = static_cast<unsigned>(std::countr_zero(left));
      if ((parent.offsets >> (4 * slot) & 0xF) == offset) return slot;
    }
    fail("the node is not on top of the stack");
  }

  void put_op(Column column, const NodeReference& popped, unsigned op) {
    std::uint8_t& last = model_[popped.parent].last_op[popped.slot];
    put(column, op ^ last);
    last = static_cast<std::uint8_t>(op);
  }

  void put_cull(Column column, const Event& event, const NodeReference& popped, unsigned dropped) {
    put_op(column, popped, dropped + event.checkpoints);
    if (event.checkpoints != 0) destination_.push_back(popped);
  }

  void put_internal(const Event& event, const NodeReference& popped) {
    constexpr Column column = Column::inner_op;
    if (event.kind() == EventKind::cull) {
      return put_cull(column, event, popped, static_cast<unsigned>(InnerOp::cull_dropped));
    }
    require(event.kind() == EventKind::visit_internal, "an internal node is on top of the stack");
    NodeModel& node = model_[event.node];
    require((event.pushed() & event.checkpoints) == 0, "a child is either pushed or checkpointed");
    require((event.pushed() | event.checkpoints) >> node.child_count == 0, "the child masks exceed the child count");
    require(event.shifts() == 0, "only an insertion shifts");
    put_op(column, popped,
           static_cast<unsigned>(event.checkpoints != 0 ? InnerOp::visit_with_checkpoints : InnerOp::visit));
    const unsigned hits = event.pushed() | event.checkpoints;
    put(Column::hits, hits ^ node.last_hits);
    node.last_hits = static_cast<std::uint8_t>(hits);
    if (event.checkpoints != 0) {  // of a single hit there is nothing to tell
      if (!std::has_single_bit(hits)) put(Column::checkpoints, gather_bits(event.checkpoints, hits));
      for (unsigned left = event.checkpoints; left != 0; left &= left - 1) {
        destination_.push_back({event.node, static_cast<std::uint32_t>(std::countr_zero(left)), popped.context});
      }
    }
    if (event.pushed() != 0) frames_.push_back({event.node, popped.context, event.pushed()});
  }

  void put_instance(const Event& event, const NodeReference& popped) {
    constexpr Column column = Column::inner_op;
    if (event.kind() == EventKind::cull) {
      return put_cull(column, event, popped, static_cast<unsigned>(InnerOp::cull_dropped));
    }
    require(event.kind() == EventKind::visit_instance && event.detail == 0, "an instance leaf is on top of the stack");
    require(header_->two_level, "instance leaves need a two-level structure");
    require(event.checkpoints == 0 && event.shifts() == 0,
            "the visit of an instance leaf has no checkpoints, no shifts");
    put_op(column, popped, static_cast<unsigned>(InnerOp::visit));
    frames_.push_back({model_.blas_root_parent(), event.node, 1});
  }

  void put_leaf(const Event& event, const NodeReference& popped) {
    constexpr Column column = Column::leaf_op;
    if (event.kind() == EventKind::cull) return put_cull(column, event, popped, kLeafCullDropped);
    require(event.kind() == EventKind::visit_leaf, "a leaf is on top of the stack");
    require(event.detail <= static_cast<unsigned>(kLastLeafOutcome), "the leaf outcome must be known");
    const bool beyond = event.outcome() == LeafOutcome::beyond;
    require(event.checkpoints <= (beyond ? 1 : 0), "only a leaf beyond t_max is checkpointed");
    const unsigned op = event.outcome() == LeafOutcome::nearest ? kLeafNearest : event.detail;
    put_op(column, popped, event.checkpoints != 0 ? kLeafBeyondCheckpointed : op);
    if (event.checkpoints != 0) destination_.push_back(popped);
    if (event.outcome() == LeafOutcome::inserted || event.outcome() == LeafOutcome::displaced) {
      put_varint(columns_[Column::shifts], event.shifts());
    } else {
      require(event.shifts() == 0, "only an insertion shifts");
    }
  }

  void put_processed(const Ray& ray) {
    std::size_t last = gaussians_.size();
    for (const Processed& entry : ray.processed) {
      const auto found = std::lower_bound(gaussians_.begin(), gaussians_.end(), entry.gaussian);
      const auto index = static_cast<std::uint32_t>(found - gaussians_.begin());
      const bool predicted = successor_[last] == index;
      put(Column::processed, (entry.blended != 0 ? kProcessedBlended : 0) | (predicted ? 0 : kProcessedNotPredicted));
      if (!predicted) {
        put(Column::gaussian_low, index & 0xFF);
        put_varint(columns_[Column::gaussian_high], index >> 8);
      }
      successor_[last] = index;
      last = index;
    }
  }

  const Header* header_ = nullptr;
  const RayGroup* group_ = nullptr;
  bool nearest_ = false;
  bool lifo_ = false;
  bool slot_order_ = false;
  std::size_t lane_ = kNowhere;
  std::size_t round_ = kNowhere;
  std::size_t event_ = kNowhere;
  ColumnSet columns_;
  GroupModel model_;
  std::vector<StackFrame> frames_;
  std::vector<NodeReference> source_;
  std::vector<NodeReference> destination_;
  std::size_t taken_ = 0;         ///< source entries read in this round
  std::int64_t last_taken_ = -1;  ///< position of the one read last
  SourceAssignment assignment_;
  const std::vector<std::uint32_t>* assigned_ = nullptr;  ///< nearest order: position of each read
  std::vector<std::uint32_t> gaussians_;                  ///< distinct, ascending
  std::vector<std::uint32_t> successor_;  ///< what followed a Gaussian last time; last place: what began a ray
};

}  // namespace

void encode_group(const Header& header, const RayGroup& group, Bytes& out) {
  thread_local GroupEncoder encoder;
  encoder.encode(header, group, out);
}

}  // namespace grtx::traces
