#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "traces/columns.h"
#include "traces/file_layout.h"
#include "traces/group_codec.h"
#include "traces/group_model.h"
#include "traces/node_shape.h"
#include "traces/source_assignment.h"

namespace grtx::traces {
namespace {

class GroupEncoder {
 public:
  [[gnu::noinline]] void encode(const Header& header, const RayGroup& group, Bytes& out) {
    header_ = &header;
    group_ = &group;
    lane_ = round_ = event_ = kNowhere;
    nearest_ = header.checkpoint_order == "nearest";
    lifo_ = header.checkpoint_order == "lifo";
    slot_order_ = header.child_order == "slot";
    reserve_columns();
    require(group.index < header.groups, "the index must be below the header's groups");
    require(group.rays.size() <= header.warp_size, "a group holds at most warp_size rays");
    require(group.kind <= RayKind::mirror, "the ray kind must be known");
    const NodeKind root = root_kind();
    try {
      model_.build(header, group.nodes, root);
    } catch (const std::invalid_argument& fault) {
      fail(fault.what());
    }
    columns_.put_varint(Column::group, group.index);
    put(Column::group, static_cast<unsigned>(group.kind));
    put(Column::group, static_cast<unsigned>(root));
    columns_.put_varint(Column::group, group.nodes.size());
    columns_.put_varint(Column::group, group.rays.size());
    if (!put_tree()) put_nodes();
    collect_gaussians();
    columns_.put_varint(Column::group, gaussians_.size());
    std::int64_t last_pixel = 0;
    for (lane_ = 0; lane_ < group.rays.size(); ++lane_) {
      const Ray& ray = group.rays[lane_];
      columns_.put_varint(Column::ray, zigzag(static_cast<std::int64_t>(ray.pixel) - last_pixel));
      columns_.put_varint(Column::ray, ray.rounds.size());
      last_pixel = ray.pixel;
      put_ray(ray);
    }
    if (columns_.bytes() > kMaxGroupBytes) {
      lane_ = kNowhere;
      fail("takes more than 1 GiB before compression");
    }
    std::array<ColumnView, kColumnCount> views;
    for (std::size_t i = 0; i < kColumnCount; ++i) views[i] = columns_.view(static_cast<Column>(i));
    pack_columns(views, out);
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
  void put(Column column, unsigned symbol) { columns_.put(column, symbol); }

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

  // No column gets longer: a varint takes 10 bytes at most, and 5 of 32 bits.
  void reserve_columns() {
    std::size_t rounds = 0, events = 0, processed = 0;
    for (const Ray& ray : group_->rays) {
      rounds += ray.rounds.size();
      events += ray.events.size();
      processed += ray.processed.size();
    }
    const std::size_t nodes = group_->nodes.size();
    columns_.reserve(Column::group, 64);
    columns_.reserve(Column::node_address, 5 * nodes);
    columns_.reserve(Column::node_tree, nodes);
    columns_.reserve(Column::node_shape, nodes);
    columns_.reserve(Column::node_kinds, 2 * nodes);
    columns_.reserve(Column::node_children, 10 * nodes);
    columns_.reserve(Column::ray, 20 * group_->rays.size());
    columns_.reserve(Column::round_flags, rounds);
    for (const Column column :
         {Column::preloaded, Column::k_count, Column::processed_count, Column::eviction_dropped}) {
      columns_.reserve(column, 5 * rounds);
    }
    for (const Column column :
         {Column::inner_op, Column::hits, Column::checkpoints, Column::pick, Column::leaf_op, Column::replay_op}) {
      columns_.reserve(column, events);
    }
    columns_.reserve(Column::shifts, 2 * events);
    columns_.reserve(Column::replay_entry, nearest_ ? 10 * events : 0);
    columns_.reserve(Column::gaussian_id, 5 * processed);
    columns_.reserve(Column::processed, processed);
    columns_.reserve(Column::gaussian_low, processed);
    columns_.reserve(Column::gaussian_high, 5 * processed);
  }

  // Depth first, a node's children before their subtrees, is the order of addresses where builders pack trees so.
  // Addresses then follow from the tree, and children lie behind all that came before. Returns false otherwise.
  bool put_tree() {
    const std::vector<NodeDefinition>& nodes = group_->nodes;
    tree_.clear();
    tree_masks_.assign(nodes.size(), 0);
    std::uint32_t next = 0;  // dictionary node that comes next in ascending order
    std::uint64_t end = 0;   // of the children so far
    unsigned flags = kNodesInTree;
    for (const bool blas : {false, true}) {
      const std::uint64_t root = blas ? header_->blas_root : header_->root;
      if ((blas && !header_->two_level) || next == nodes.size() || nodes[next].address * kNodeUnit != root) continue;
      flags |= blas ? kNodesHoldBlasRoot : kNodesHoldRoot;
      walk_.assign(1, next++);
      while (!walk_.empty()) {
        const std::uint32_t index = walk_.back();
        walk_.pop_back();
        tree_.push_back(index);
        const NodeModel& node = model_[index];
        if (node.child_base < end) return false;
        end = node.child_base + model_.shape(*header_, nodes[index]).units;
        const std::size_t first = walk_.size();
        for (unsigned left = node.internal_mask; left != 0; left &= left - 1) {
          const unsigned slot = static_cast<unsigned>(std::countr_zero(left));
          if (next == nodes.size() || nodes[next].address != node.child_address(slot)) continue;
          tree_masks_[index] = static_cast<std::uint8_t>(tree_masks_[index] | 1U << slot);
          walk_.push_back(next++);
        }
        std::reverse(walk_.begin() + static_cast<std::ptrdiff_t>(first), walk_.end());
      }
    }
    if (next != nodes.size()) return false;
    put(Column::group, flags);
    end = 0;
    for (const std::uint32_t index : tree_) {
      NodeModel& node = model_[index];
      columns_.put_varint(Column::node_children, node.child_base - end);
      end = node.child_base + model_.shape(*header_, nodes[index]).units;
      put_shape(nodes[index]);
      if (node.internal_mask != 0) put(Column::node_tree, tree_masks_[index]);
      node.last_hits = tree_masks_[index];
    }
    return true;
  }

  void put_nodes() {
    put(Column::group, 0);
    std::int64_t last_address = 0;
    std::int64_t predicted_children = 0;
    for (const NodeDefinition& node : group_->nodes) {
      columns_.put_varint(Column::node_address, static_cast<std::uint64_t>(node.address - last_address));
      last_address = node.address;
      columns_.put_varint(Column::node_children,
                          zigzag(static_cast<std::int64_t>(node.child_base) - predicted_children));
      predicted_children = static_cast<std::int64_t>(node.child_base + model_.shape(*header_, node).units);
      put_shape(node);
    }
  }

  // Nodes mostly have leaves of one kind: their kind, and a mask of the internal children if there are both.
  void put_shape(const NodeDefinition& node) {
    const NodeShape& shape = model_.shape(*header_, node);
    const unsigned leaves = ((1U << node.child_count) - 1) & ~unsigned{shape.internal_mask};
    const unsigned leaf =
        leaves != 0 ? stored_kind(node.child_kinds[static_cast<unsigned>(std::countr_zero(leaves))]) : 0;
    bool irregular = false;
    for (unsigned left = leaves; left != 0; left &= left - 1) {
      irregular |= stored_kind(node.child_kinds[static_cast<unsigned>(std::countr_zero(left))]) != leaf;
    }
    const bool mixed = leaf != 0 && shape.internal_mask != 0 && !irregular;
    put(Column::node_shape,
        node.child_count | (irregular ? 0 : leaf) << 4 | (mixed ? kShapeMixed : 0) | (irregular ? kShapeIrregular : 0));
    if (mixed) put(Column::node_kinds, shape.internal_mask);
    if (irregular) {
      unsigned kinds = 0;
      for (unsigned slot = 0; slot < node.child_count; ++slot)
        kinds |= stored_kind(node.child_kinds[slot]) << (2 * slot);
      put(Column::node_kinds, kinds & 0xFF);
      put(Column::node_kinds, kinds >> 8);
    }
  }

  static unsigned stored_kind(NodeKind kind) {
    switch (kind) {
      case NodeKind::internal:
        return 0;
      case NodeKind::instance:
        return 1;
      case NodeKind::procedural:
        return 2;
      default:
        return 3;  // GroupModel::build has refused unknown kinds
    }
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
      columns_.put_varint(Column::gaussian_id, gaussian - last);
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
      columns_.put_varint(Column::preloaded, round.preloaded);
      columns_.put_varint(Column::k_count, round.k_count);
      columns_.put_varint(Column::processed_count,
                          zigzag(static_cast<std::int64_t>(round.k_count) - round.processed_count));
      if (round.overflow) columns_.put_varint(Column::eviction_dropped, round.eviction_dropped);
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
      columns_.put_varint(Column::replay_entry, zigzag(static_cast<std::int64_t>(index) - last_taken_ - 1));
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
    const std::uint32_t address = internal_event ? model_.address(event.node) : event.node;
    const unsigned slot = parent.slot_of(frame.remaining, address);
    require(slot < kMaxWidth, "the node is not on top of the stack");
    if (has_one_bit(frame.remaining)) {
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
      if (!has_one_bit(hits)) put(Column::checkpoints, gather_bits(event.checkpoints, hits));
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
      columns_.put_varint(Column::shifts, event.shifts());
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
        columns_.put_varint(Column::gaussian_high, index >> 8);
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
  ColumnWriter columns_;
  GroupModel model_;
  std::vector<std::uint32_t> tree_;       ///< dictionary in the order of put_tree()
  std::vector<std::uint8_t> tree_masks_;  ///< children in the dictionary
  std::vector<std::uint32_t> walk_;
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
  // On the heap: members of a thread_local object would each be reached through the thread pointer.
  thread_local const std::unique_ptr<GroupEncoder> encoder = std::make_unique<GroupEncoder>();
  encoder->encode(header, group, out);
}

}  // namespace grtx::traces
