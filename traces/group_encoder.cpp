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
  void put_pops(Column gaps, Column symbols, ColumnView pops, unsigned& run);
  void put_checkpoints(const Event& visit, std::uint32_t index, std::uint32_t context);
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
  unsigned inner_run_ = 0, leaf_run_ = 0;  ///< predicted pops since the last other one
  Bytes inner_symbols_, leaf_symbols_;     ///< of the ray's pops, the predicted ones as well
  std::size_t inner_count_ = 0, leaf_count_ = 0;
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
  if (frames_.size() < events + 2) {
    frames_.resize(2 * events + 2);
    inner_symbols_.resize(frames_.size());
    leaf_symbols_.resize(frames_.size());
  }
  inner_count_ = leaf_count_ = 0;
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
  put_pops(Column::inner_gap, Column::inner, {inner_symbols_.data(), inner_count_}, inner_run_);
  put_pops(Column::leaf_gap, Column::leaf, {leaf_symbols_.data(), leaf_count_}, leaf_run_);
  ++totals_.rays;
  totals_.processed += ray.processed.size();
  for (const Processed& entry : ray.processed) totals_.blended += entry.blended;
  processed_.add(ray.processed);
  place_.lane = GroupPlace::kNowhere;
}

void GroupEncoder::Impl::put_events(const Round& round, std::span<const Event> events,
                                    std::uint64_t& in_eviction_buffer) {
  static constexpr std::uint8_t kLeafOps[8] = {0, 1, 2, 3, 4, 5, 6, kLeafNearest};
  static constexpr unsigned kShiftingOps =
      1U << static_cast<unsigned>(LeafOutcome::inserted) | 1U << static_cast<unsigned>(LeafOutcome::displaced);
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
  StackFrame top{GroupModel::kRootParent, 0, round.replay ? 0U : 1U};
  std::size_t depth = 0;  // of the frames below
  NodeModel* nodes = model_.nodes();
  std::uint8_t* leaves_end = leaf_symbols_.data() + leaf_count_;
  std::uint8_t* inner_end = inner_symbols_.data() + inner_count_;
  std::uint8_t* hits_end = columns_.end(Column::hits);
  RoundCounts counts;
  const Event* const end = events.data() + events.size();
  for (const Event* event = events.data(); event != end; ++event) {
    if (top.remaining == 0) {
      if (depth == 0) {
        ++counts.read;
        counts.written += event->checkpoints & 1U;
        if (!read_source(event, top) || !model_.is_blas(event->node)) continue;
        require(event + 1 != end, event, "visit_instance must follow the take of a BLAS node");
        ++event;
        ++counts.instances;
        require(event->kind() == EventKind::visit_instance && event->detail == 1 && event->node == top.context &&
                    event->checkpoints == 0 && event->shifts() == 0,
                event,
                "must be the visit of the instance leaf through which the taken BLAS node was reached (detail 1)");
        continue;
      }
      top = frames[--depth];
    }
    NodeModel* parent = nodes + top.parent;
    const unsigned first = NodeModel::first_of(parent->ordered(top.remaining));
    const unsigned inner = parent->internal_mask | parent->instance_mask;
    unsigned slot = first;
    unsigned rank = 0;
    unsigned crosses = 0;  // 1: a leaf where none was expected, or the reverse
    if (parent->child_address(first) != event->node) {
      slot = parent->slot_of(top.remaining, event->node);
      require(slot < kMaxWidth, event, "the node is not on top of the stack");
      require(!slot_order_, event, "children must be popped in slot order");
      rank = parent->rank_of(top.remaining, slot) << kPopRankShift;
      crosses = (inner >> slot ^ inner >> first) & 1;
      parent->move_up(top.remaining, slot);
    }
    top.remaining &= ~(1U << slot);
    const EventKind kind = event->kind();
    if (kind == EventKind::visit_leaf) {
      require((inner >> slot & 1) == 0, event, "no leaf is on top of the stack");
      require(event->detail <= static_cast<unsigned>(kLastLeafOutcome), event, "the leaf outcome must be known");
      ++counts.leaves[event->detail];
      unsigned op = kLeafOps[event->detail];
      if (event->checkpoints != 0) {
        require(event->checkpoints == 1 && event->outcome() == LeafOutcome::beyond, event,
                "only a leaf beyond t_max is checkpointed");
        op = kLeafBeyondCheckpointed;
        ++counts.written;
        destination_.push_back({top.parent, slot, top.context});
      }
      const unsigned symbol = (op ^ parent->last_op[slot]) | rank;
      parent->last_op[slot] = static_cast<std::uint8_t>(op);
      *(crosses != 0 ? inner_end : leaves_end)++ = static_cast<std::uint8_t>(symbol);
      if ((kShiftingOps >> op & 1) != 0) {
        columns_.put_varint(Column::shifts, event->shifts());
      } else {
        require(event->shifts() == 0, event, "only an insertion shifts");
      }
      continue;
    }
    unsigned op = static_cast<unsigned>(InnerOp::visit);
    unsigned changed_hits = 0;
    StackFrame pushed;
    if (kind == EventKind::visit_internal) {
      require(parent->is_internal(slot), event, "no internal node is on top of the stack");
      const unsigned hits = event->pushed() | event->checkpoints;
      std::uint32_t index = parent->links[slot];
      if (index == NodeModel::kUnknownLink) {
        index = dictionary_.reach(top.parent, slot, event->node, hits);
        nodes = model_.nodes();
        parent = nodes + top.parent;
      }
      NodeModel& node = nodes[index];
      require(((event->pushed() & event->checkpoints) | hits >> node.child_count | event->shifts()) == 0, event,
              "a visit pushes or checkpoints children that exist, each once, and shifts nothing");
      ++counts.internal;
      changed_hits = hits ^ node.last_hits;
      *hits_end = static_cast<std::uint8_t>(changed_hits);
      hits_end += changed_hits != 0 ? 1 : 0;
      changed_hits = changed_hits != 0 ? kPopHits : 0;
      node.last_hits = static_cast<std::uint8_t>(hits);
      pushed = {index, top.context, event->pushed()};
      if (event->checkpoints != 0) {
        op = static_cast<unsigned>(InnerOp::visit_with_checkpoints);
        put_checkpoints(*event, index, top.context);
        counts.written += bits_of_byte(event->checkpoints);
      }
    } else if (kind == EventKind::cull) {
      require(event->detail == 0 && event->shifts() == 0, event, "a cull has no detail and no shifts");
      require(event->checkpoints <= 1, event, "a cull writes at most one checkpoint");
      ++counts.culls;
      counts.written += event->checkpoints;
      if (event->checkpoints != 0) destination_.push_back({top.parent, slot, top.context});
      op = ((inner >> slot & 1) != 0 ? static_cast<unsigned>(InnerOp::cull_dropped) : kLeafCullDropped) +
           event->checkpoints;
    } else {
      require(kind == EventKind::visit_instance && event->detail == 0 && parent->is_instance(slot), event,
              "the event does not handle the node on top of the stack");
      require(header_->two_level, event, "instance leaves need a two-level structure");
      require(event->checkpoints == 0 && event->shifts() == 0, event,
              "the visit of an instance leaf has no checkpoints, no shifts");
      ++counts.instances;
      pushed = {GroupModel::kBlasRootParent, event->node, 1};
    }
    const unsigned symbol = (op ^ parent->last_op[slot]) | rank | changed_hits;
    parent->last_op[slot] = static_cast<std::uint8_t>(op);
    const bool as_inner = ((inner >> slot ^ crosses) & 1) != 0;
    *(as_inner ? inner_end : leaves_end)++ = static_cast<std::uint8_t>(symbol);
    if (pushed.remaining == 0) continue;
    frames[depth] = top;
    depth += top.remaining != 0 ? 1 : 0;
    top = pushed;
  }
  require(top.remaining == 0 && depth == 0, "the stack must be empty at the end of a round");
  require(taken_ == source_.size(), "every source entry must be read");
  if (round.overflow) destination_.clear();
  columns_.end(Column::hits) = hits_end;
  leaf_count_ = static_cast<std::size_t>(leaves_end - leaf_symbols_.data());
  inner_count_ = static_cast<std::size_t>(inner_end - inner_symbols_.data());
  count_round(*header_, round, counts, in_eviction_buffer, totals_);
}

// A loop of its own, whose state fits the registers.
void GroupEncoder::Impl::put_pops(Column gaps, Column symbols, ColumnView pops, unsigned& run) {
  PopColumns out{columns_.end(gaps), columns_.end(symbols), run};
  for (const std::uint8_t symbol : pops) out.put(symbol);
  columns_.end(gaps) = out.gap;
  columns_.end(symbols) = out.symbols;
  run = out.run;
}

// Of a single hit there is nothing to tell.
void GroupEncoder::Impl::put_checkpoints(const Event& visit, std::uint32_t index, std::uint32_t context) {
  const unsigned hits = visit.pushed() | visit.checkpoints;
  if (!has_one_bit(hits)) columns_.put(Column::checkpoints, gather_bits(visit.checkpoints, hits));
  for (unsigned left = visit.checkpoints; left != 0; left &= left - 1) {
    destination_.push_back({index, static_cast<std::uint32_t>(std::countr_zero(left)), context});
  }
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
