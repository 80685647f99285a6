#include "traces/group_encoder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <vector>

#include "base/hash.h"
#include "traces/columns.h"
#include "traces/count_totals.h"
#include "traces/dictionary_encoder.h"
#include "traces/file_layout.h"
#include "traces/group_codec.h"
#include "traces/group_model.h"
#include "traces/group_place.h"
#include "traces/node_shape.h"
#include "traces/predicted_pops.h"
#include "traces/processed_coder.h"
#include "traces/source_assignment.h"

namespace grtx::traces {

struct GroupEncoder::Impl {
  void begin(const Header& header, std::uint32_t index, RayKind kind, NodeKind root, const NodeSource& nodes);
  void list(const std::vector<NodeDefinition>& nodes) { dictionary_.list(nodes); }
  void add(const TracedRay& ray);
  void finish(EncodedGroup& group);

 private:
  void require(bool holds, const char* rule) const { place_.require(holds, rule); }
  [[noreturn, gnu::cold, gnu::noinline]] void fail_at(const Event* event, const char* rule) {
    place_.event = static_cast<std::size_t>(event - round_events_);
    place_.fail(rule);
  }
  void require(bool holds, const Event* event, const char* rule) {
    if (!holds) [[unlikely]]
      fail_at(event, rule);
  }

  void reserve_columns(const TracedRay& ray);
  void put_events(const Round& round, std::span<const Event> events, std::uint64_t& in_eviction_buffer);
  bool read_source(const Event* event, StackFrame& taken);
  void end_gap(Column column, unsigned run) {
    columns_.reserve(column, 1);
    if (run > 0) columns_.put(column, run);
  }

  const Header* header_ = nullptr;
  RayKind kind_ = RayKind::primary;
  NodeKind root_ = NodeKind::internal;
  bool nearest_ = false;
  bool lifo_ = false;
  bool slot_order_ = false;
  std::uint64_t pops_ = 0;
  std::int64_t last_pixel_ = 0;
  std::size_t rays_ = 0;
  GroupPlace place_;
  const Event* round_events_ = nullptr;

  Totals totals_;
  ColumnWriter columns_;
  unsigned inner_run_ = 0;
  unsigned leaf_run_ = 0;
  GroupModel model_;
  DictionaryEncoder dictionary_{model_, place_};
  ProcessedEncoder processed_;
  std::vector<StackFrame> frames_;
  std::vector<NodeReference> source_;
  std::vector<NodeReference> destination_;
  std::size_t taken_ = 0;         ///< source entries read in this round
  std::int64_t last_taken_ = -1;  ///< position of the one read last
  SourceAssignment assignment_;
  std::vector<std::uint32_t> addresses_;                  ///< nearest order: of the source entries
  const std::vector<std::uint32_t>* assigned_ = nullptr;  ///< nearest order: position of each read
};

void GroupEncoder::Impl::begin(const Header& header, std::uint32_t index, RayKind kind, NodeKind root,
                               const NodeSource& nodes) {
  header_ = &header;
  place_ = GroupPlace{};
  place_.group = index;
  kind_ = kind;
  root_ = root;
  nearest_ = header.checkpoint_order == "nearest";
  lifo_ = header.checkpoint_order == "lifo";
  slot_order_ = header.child_order == "slot";
  pops_ = 0;
  last_pixel_ = 0;
  rays_ = 0;
  totals_ = Totals{};
  columns_.clear();
  inner_run_ = leaf_run_ = 0;
  dictionary_.begin(nodes);
  processed_.clear();
  require(index < header.groups, "the index must be below the header's groups");
  require(kind <= RayKind::mirror, "the ray kind must be known");
  model_.begin(header, root);
}

// A varint takes 10 bytes at most, 5 of 32 bits, and 2 of 12 bits.
void GroupEncoder::Impl::reserve_columns(const TracedRay& ray) {
  const std::size_t events = ray.events.size(), rounds = ray.rounds.size();
  for (const Column column : {Column::inner_gap, Column::inner, Column::hits, Column::checkpoints, Column::leaf_gap,
                              Column::leaf, Column::replay_op}) {
    columns_.reserve(column, events + 2);
  }
  columns_.reserve(Column::shifts, 2 * events);
  if (nearest_) columns_.reserve(Column::replay_entry, 10 * events);
  columns_.reserve(Column::ray, 20);
  columns_.reserve(Column::round_flags, rounds);
  for (const Column column : {Column::preloaded, Column::k_count, Column::processed_count, Column::eviction_dropped}) {
    columns_.reserve(column, 5 * rounds);
  }
  if (frames_.size() < events + 2) frames_.resize(2 * events + 2);
}

void GroupEncoder::Impl::add(const TracedRay& ray) {
  place_.lane = rays_++;
  require(rays_ <= header_->warp_size, "a group holds at most warp_size rays");
  require(ray.events.size() <= kMaxPops - pops_, "a group has at most 2^30 events");
  pops_ += ray.events.size();
  reserve_columns(ray);
  columns_.put_varint(Column::ray, zigzag(static_cast<std::int64_t>(ray.pixel) - last_pixel_));
  columns_.put_varint(Column::ray, ray.rounds.size());
  last_pixel_ = ray.pixel;
  destination_.clear();
  std::size_t next_event = 0;
  std::size_t processed = 0;
  std::uint64_t in_eviction_buffer = 0;
  for (place_.round = 0; place_.round < ray.rounds.size(); ++place_.round) {
    const Round& round = ray.rounds[place_.round];
    require(round.event_count <= ray.events.size() - next_event, "event_count exceeds the ray's events");
    require(round.processed_count <= ray.processed.size() - processed, "processed_count exceeds the ray's entries");
    require(round.overflow || round.eviction_dropped == 0, "evictions are only dropped by an overflow");
    columns_.put(Column::round_flags, (round.replay ? kRoundReplay : 0) | (round.overflow ? kRoundOverflow : 0) |
                                          (round.terminated ? kRoundTerminated : 0));
    columns_.put_varint(Column::preloaded, round.preloaded);
    columns_.put_varint(Column::k_count, round.k_count);
    columns_.put_varint(Column::processed_count,
                        zigzag(static_cast<std::int64_t>(round.k_count) - round.processed_count));
    if (round.overflow) columns_.put_varint(Column::eviction_dropped, round.eviction_dropped);
    put_events(round, ray.events.subspan(next_event, round.event_count), in_eviction_buffer);
    next_event += round.event_count;
    processed += round.processed_count;
  }
  place_.round = GroupPlace::kNowhere;
  require(next_event == ray.events.size(), "events remain behind the last round");
  require(processed == ray.processed.size(), "processed entries remain behind the last round");
  ++totals_.rays;
  totals_.processed += ray.processed.size();
  for (const Processed& entry : ray.processed) totals_.blended += entry.blended;
  processed_.add(ray.processed);
  place_.lane = GroupPlace::kNowhere;
}

void GroupEncoder::Impl::put_events(const Round& round, std::span<const Event> events,
                                    std::uint64_t& in_eviction_buffer) {
  static constexpr std::uint8_t kLeafOps[8] = {0, 1, 2, 3, 4, 5, 6, kLeafNearest};
  round_events_ = events.data();
  source_.clear();
  if (round.replay) source_.swap(destination_);
  destination_.clear();
  taken_ = 0;
  last_taken_ = -1;
  if (nearest_ && round.replay) {
    addresses_.clear();
    for (const NodeReference& entry : source_) addresses_.push_back(model_[entry.parent].child_address(entry.slot));
    assigned_ = &assignment_.assign(addresses_, source_, events, model_.blas_begin());
  }
  StackFrame* const frames = frames_.data();
  std::size_t depth = 0;
  if (!round.replay) frames[depth++] = {GroupModel::kRootParent, 0, 1};
  NodeModel* nodes = model_.nodes();
  PopColumns pops[2] = {{columns_.end(Column::leaf_gap), columns_.end(Column::leaf), leaf_run_},
                        {columns_.end(Column::inner_gap), columns_.end(Column::inner), inner_run_}};
  std::uint8_t* hits_end = columns_.end(Column::hits);
  RoundCounts counts;
  const Event* const end = events.data() + events.size();
  for (const Event* event = events.data(); event != end; ++event) {
    if (depth == 0) {
      ++counts.read;
      counts.written += event->checkpoints & 1U;
      if (!read_source(event, frames[0])) continue;
      depth = 1;
      if (!model_.is_blas(event->node)) continue;
      require(event + 1 != end, event, "visit_instance must follow the take of a BLAS node");
      ++event;
      ++counts.instances;
      require(event->kind() == EventKind::visit_instance && event->detail == 1 && event->node == frames[0].context &&
                  event->checkpoints == 0 && event->shifts() == 0,
              event, "must be the visit of the instance leaf through which the taken BLAS node was reached (detail 1)");
      continue;
    }
    StackFrame& frame = frames[depth - 1];
    const StackFrame before = frame;
    NodeModel* parent = nodes + before.parent;
    const unsigned slot = parent->slot_of(before.remaining, event->node);
    require(slot < kMaxWidth, event, "the node is not on top of the stack");
    unsigned rank = 0;
    unsigned expected = slot;
    if (slot_order_) {
      require(slot == static_cast<unsigned>(std::countr_zero(before.remaining)), event,
              "children must be popped in slot order");
    } else {
      rank = parent->rank_of(before.remaining, slot);
      if (rank != 0) {
        expected = NodeModel::first_of(parent->ordered(before.remaining));
        parent->move_up(before.remaining, slot);
      }
    }
    PopColumns& column = pops[(parent->internal_mask | parent->instance_mask) >> expected & 1];
    frame.remaining = before.remaining & ~(1U << slot);
    depth -= frame.remaining == 0 ? 1 : 0;
    const NodeReference popped{before.parent, slot, before.context};
    const EventKind kind = event->kind();
    if (kind == EventKind::visit_leaf) {
      require(!parent->is_internal(slot) && !parent->is_instance(slot), event, "no leaf is on top of the stack");
      require(event->detail <= static_cast<unsigned>(kLastLeafOutcome), event, "the leaf outcome must be known");
      ++counts.leaves[event->detail];
      const LeafOutcome outcome = event->outcome();
      unsigned op = kLeafOps[event->detail];
      if (event->checkpoints != 0) {
        require(event->checkpoints == 1 && outcome == LeafOutcome::beyond, event,
                "only a leaf beyond t_max is checkpointed");
        op = kLeafBeyondCheckpointed;
        ++counts.written;
        destination_.push_back(popped);
      }
      column.put((op ^ parent->last_op[slot]) | rank << kPopRankShift);
      parent->last_op[slot] = static_cast<std::uint8_t>(op);
      if (outcome == LeafOutcome::inserted || outcome == LeafOutcome::displaced) {
        columns_.put_varint(Column::shifts, event->shifts());
      } else {
        require(event->shifts() == 0, event, "only an insertion shifts");
      }
      continue;
    }
    unsigned op = static_cast<unsigned>(InnerOp::visit);
    unsigned changed_hits = 0;
    if (kind == EventKind::visit_internal) {
      require(parent->is_internal(slot), event, "no internal node is on top of the stack");
      const unsigned hits = event->pushed() | event->checkpoints;
      std::uint32_t index = parent->links[slot];
      if (index == NodeModel::kUnknownLink) {
        index = dictionary_.reach(before.parent, slot, event->node, hits);
        nodes = model_.nodes();
        parent = nodes + before.parent;
      }
      NodeModel& node = nodes[index];
      require(((event->pushed() & event->checkpoints) | hits >> node.child_count | event->shifts()) == 0, event,
              "a visit pushes or checkpoints children that exist, each once, and shifts nothing");
      ++counts.internal;
      changed_hits = hits ^ node.last_hits;
      *hits_end = static_cast<std::uint8_t>(changed_hits);
      hits_end += changed_hits != 0 ? 1 : 0;
      node.last_hits = static_cast<std::uint8_t>(hits);
      if (event->checkpoints != 0) {  // of a single hit there is nothing to tell
        op = static_cast<unsigned>(InnerOp::visit_with_checkpoints);
        if (!has_one_bit(hits)) columns_.put(Column::checkpoints, gather_bits(event->checkpoints, hits));
        for (unsigned left = event->checkpoints; left != 0; left &= left - 1) {
          destination_.push_back({index, static_cast<std::uint32_t>(std::countr_zero(left)), before.context});
        }
        counts.written += bits_of_byte(event->checkpoints);
      }
      frames[depth] = {index, before.context, event->pushed()};
      depth += event->pushed() != 0 ? 1 : 0;
    } else if (kind == EventKind::cull) {
      require(event->detail == 0 && event->shifts() == 0, event, "a cull has no detail and no shifts");
      require(event->checkpoints <= 1, event, "a cull writes at most one checkpoint");
      ++counts.culls;
      counts.written += event->checkpoints;
      if (event->checkpoints != 0) destination_.push_back(popped);
      if (!parent->is_internal(slot) && !parent->is_instance(slot)) {
        op = kLeafCullDropped + event->checkpoints;
        column.put((op ^ parent->last_op[slot]) | rank << kPopRankShift);
        parent->last_op[slot] = static_cast<std::uint8_t>(op);
        continue;
      }
      op = static_cast<unsigned>(InnerOp::cull_dropped) + event->checkpoints;
    } else {
      require(kind == EventKind::visit_instance && event->detail == 0 && parent->is_instance(slot), event,
              "the event does not handle the node on top of the stack");
      require(header_->two_level, event, "instance leaves need a two-level structure");
      require(event->checkpoints == 0 && event->shifts() == 0, event,
              "the visit of an instance leaf has no checkpoints, no shifts");
      ++counts.instances;
      frames[depth++] = {GroupModel::kBlasRootParent, event->node, 1};
    }
    column.put((op ^ parent->last_op[slot]) | rank << kPopRankShift | (changed_hits != 0 ? kPopHits : 0));
    parent->last_op[slot] = static_cast<std::uint8_t>(op);
  }
  require(depth == 0, "the stack must be empty at the end of a round");
  require(taken_ == source_.size(), "every source entry must be read");
  if (round.overflow) destination_.clear();
  columns_.end(Column::leaf_gap) = pops[0].gap;
  columns_.end(Column::leaf) = pops[0].symbols;
  columns_.end(Column::inner_gap) = pops[1].gap;
  columns_.end(Column::inner) = pops[1].symbols;
  columns_.end(Column::hits) = hits_end;
  inner_run_ = pops[1].run;
  leaf_run_ = pops[0].run;
  count_round(*header_, round, counts, in_eviction_buffer, totals_);
}

/// Returns whether the entry was pushed: `taken` is its frame.
bool GroupEncoder::Impl::read_source(const Event* event, StackFrame& taken) {
  const bool take = event->kind() == EventKind::replay_take;
  require(take || event->kind() == EventKind::replay_forward, event,
          "the stack is empty: only a source entry can come next");
  require(taken_ < source_.size(), event, "no source entry is left to read");
  std::size_t index = taken_;
  if (lifo_) index = source_.size() - 1 - taken_;
  if (nearest_) {
    require((*assigned_)[taken_] != SourceAssignment::kNone, event, "no unread source entry has this address");
    index = (*assigned_)[taken_];
    columns_.put_varint(Column::replay_entry, zigzag(static_cast<std::int64_t>(index) - last_taken_ - 1));
    last_taken_ = static_cast<std::int64_t>(index);
  }
  ++taken_;
  const NodeReference entry = source_[index];
  require(event->node == model_[entry.parent].child_address(entry.slot), event, "must read the next source entry");
  require(event->detail == 0 && event->shifts() == 0, event, "a replay event has no detail and no shifts");
  require(event->checkpoints <= (take ? 0 : 1), event, "a forward writes at most one checkpoint, a take none");
  if (take) {
    columns_.put(Column::replay_op, static_cast<unsigned>(ReplayOp::take));
    taken = {entry.parent, entry.context, 1U << entry.slot};
    return true;
  }
  columns_.put(Column::replay_op, static_cast<unsigned>(event->checkpoints != 0 ? ReplayOp::forward_checkpointed
                                                                                : ReplayOp::forward_dropped));
  if (event->checkpoints != 0) destination_.push_back(entry);
  return false;
}

void GroupEncoder::Impl::finish(EncodedGroup& group) {
  const unsigned flags = dictionary_.put(columns_);
  const std::size_t gaussians = processed_.put(columns_);
  end_gap(Column::inner_gap, inner_run_);
  end_gap(Column::leaf_gap, leaf_run_);
  columns_.reserve(Column::group, 64);
  columns_.put_varint(Column::group, place_.group);
  columns_.put(Column::group, static_cast<unsigned>(kind_));
  columns_.put(Column::group, static_cast<unsigned>(root_));
  columns_.put_varint(Column::group, dictionary_.size());
  columns_.put_varint(Column::group, rays_);
  columns_.put(Column::group, flags);
  columns_.put_varint(Column::group, gaussians);
  if (columns_.bytes() > kMaxGroupBytes) place_.fail("takes more than 1 GiB before compression");
  std::array<ColumnView, kColumnCount> views;
  for (std::size_t i = 0; i < kColumnCount; ++i) views[i] = columns_.view(static_cast<Column>(i));
  group.index = place_.group;
  group.totals = totals_;
  group.chunk.assign(kChunkPreambleBytes, 0);
  pack_columns(views, group.chunk);
  const std::size_t payload = group.chunk.size() - kChunkPreambleBytes;
  Bytes preamble;
  put_u32(preamble, static_cast<std::uint32_t>(payload));
  put_u64(preamble, xxh3(group.chunk.data() + kChunkPreambleBytes, payload));
  std::copy(preamble.begin(), preamble.end(), group.chunk.begin());
}

GroupEncoder::GroupEncoder() : impl_(std::make_unique<Impl>()) {}
GroupEncoder::~GroupEncoder() = default;
GroupEncoder::GroupEncoder(GroupEncoder&&) noexcept = default;
GroupEncoder& GroupEncoder::operator=(GroupEncoder&&) noexcept = default;

void GroupEncoder::begin(const Header& header, std::uint32_t index, RayKind kind, NodeKind root,
                         const NodeSource& nodes) {
  impl_->begin(header, index, kind, root, nodes);
}
void GroupEncoder::add(const TracedRay& ray) { impl_->add(ray); }
void GroupEncoder::list(const std::vector<NodeDefinition>& nodes) { impl_->list(nodes); }
void GroupEncoder::finish(EncodedGroup& group) { impl_->finish(group); }

}  // namespace grtx::traces
