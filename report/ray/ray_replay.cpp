// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/ray/ray_replay.h"

#include <algorithm>
#include <span>
#include <stdexcept>

#include "grtx/base/error.h"
#include "grtx/report/ray/handled_order.h"
#include "grtx/report/ray/packed_round.h"
#include "grtx/traces/instance_levels.h"
#include "grtx/traces/rules/checkpoint_lists.h"
#include "grtx/traces/rules/round_hits.h"
#include "grtx/traces/source_assignment.h"

namespace grtx::report {

using traces::Event;
using traces::EventKind;
using traces::LeafOutcome;

namespace {

class Replay {
 public:
  Replay(const std::string& file, const traces::Header& header, const traces::RayGroup& group, unsigned lane,
         const RayNodes& nodes, const RayValues* values)
      : file_(file),
        header_(header),
        group_(group),
        lane_(lane),
        ray_(group.rays[lane]),
        nodes_(nodes),
        levels_(header),
        values_(values),
        hits_(traces::RoundRules(header)),
        checkpoints_(header),
        out_(values != nullptr) {}

  ReplayedRay run() {
    // Gaussians of leaves follow only from later rounds. A first replay collects them; the second one produces the
    // result.
    const RayValues* const values = std::exchange(values_, nullptr);
    replay();
    values_ = values;
    learning_ = false;
    replay();
    result_.learnt = std::move(gaussian_of_);
    return std::move(result_);
  }

 private:
  static constexpr std::size_t kNobody = ~std::size_t{0};

  void require(bool holds, const char* rule) const {
    if (holds) return;
    std::string place = "group " + std::to_string(group_.index) + " lane " + std::to_string(lane_);
    place += " round " + std::to_string(result_.rounds.size() - 1);
    if (event_ != kNobody) place += " event " + std::to_string(event_);
    throw Error(file_, place, rule);
  }

  void replay() {
    hits_.begin_ray();
    checkpoints_.begin_ray();
    next_bin_ = 0;
    made_ = 0;
    time_ = 0;
    result_.rounds.clear();
    std::size_t first = 0, processed = 0;
    for (std::size_t r = 0; r < ray_.rounds.size(); ++r) {
      const traces::Round& round = ray_.rounds[r];
      events_ = {ray_.events.data() + first, round.event_count};
      children_ = children_of(events_);
      RayRound& out = result_.rounds.emplace_back();
      out.round = round;
      HandledOrder handled;
      if (header_.ahead > 1) handled = handled_order(events_, header_.ahead);
      begin_round(r, out);
      if (header_.ahead > 1) start(handled.started[0]);
      for (std::size_t i = 0; i < events_.size(); ++i) {
        event_ = header_.ahead > 1 ? handled.events[i] : i;
        take(events_[event_], values_ != nullptr ? values_->t_max[first + i] : kUnknownTime, out);
        if (header_.ahead > 1) start(handled.started[i + 1]);
      }
      event_ = kNobody;
      end_round(round, processed, out);
      first += round.event_count;
      processed += round.processed_count;
    }
  }

  // Rounds.

  void begin_round(std::size_t r, const RayRound& out) {
    if (values_ != nullptr || hits_.evictions().size() < 2) {
      hits_.begin_round(out.round.preloaded);
    } else {  // the trace does not tell which are nearest
      hits_.begin_round(out.round.preloaded, [this] { return unknown_hit(); });
    }
    if (values_ != nullptr) compare(values_->start_hits[r]);
    checkpoints_.begin_round(out.round.replay, out.round.bins);
    if (values_ != nullptr) {
      traces::with_checkpoint_order(header_.checkpoint_order,
                                    [this](auto policy) { policy.arrange(checkpoints_.source()); });
    }
    source_.clear();
    if (!checkpoints_.has_bins()) source_ = checkpoints_.source();
    for (auto rest = checkpoints_; rest.has_bins() && rest.more();) source_.push_back(rest.read());
    assign_sources(out.round);
    stack_.clear();
    if (!out.round.replay && !events_.empty()) stack_.push_back({root(header_.root), 0, 0, 0.0f});
    if (values_ != nullptr) t_max_ = values_->start_t_max[r];
    out_.list(hits_.k_buffer().entries());
    out_.list(hits_.evictions());
    out_.list(source_);
    out_.list(stack_);
    out_.time(t_max_);
  }

  void compare(const std::vector<std::pair<float, std::uint32_t>>& hits) const {
    const std::vector<HitEntry>& found = hits_.k_buffer().entries();
    const bool same =
        std::equal(hits.begin(), hits.end(), found.begin(), found.end(), [](const auto& hit, const HitEntry& entry) {
          return hit.first == entry.t && (entry.gaussian == 0 || hit.second + 1 == entry.gaussian);
        });
    if (!same) throw std::logic_error("a ray's k-buffer is not what its replay says");
  }

  void assign_sources(const traces::Round& round) {
    places_.clear();
    if (!round.replay || checkpoints_.order().by_place()) return;
    std::vector<std::uint32_t> addresses;
    std::vector<traces::NodeReference> references(source_.size());
    for (std::size_t i = 0; i < source_.size(); ++i) {
      addresses.push_back(nodes_[source_[i].node].units);
      if (source_[i].object != 0) references[i].path.scene = nodes_[source_[i].object - 1].units;
      if (source_[i].instance != 0) references[i].path.instance = nodes_[source_[i].instance - 1].units;
    }
    places_ = assignment_.assign(addresses, references, events_, levels_);
  }

  /// Says which nodes are under way from now on, by their events.
  void start(const std::vector<std::uint32_t>& started) {
    out_.number(started.size());
    for (const std::uint32_t event : started) out_.number(from_top(find(number_of(events_[event]))));
  }

  void end_round(const traces::Round& round, std::size_t processed, RayRound& out) {
    const std::vector<HitEntry>& hits = hits_.k_buffer().entries();
    require(hits.size() == round.k_count, "k_count must be the entries of the k-buffer");
    for (std::size_t i = 0; i < round.processed_count; ++i) {
      const traces::Processed entry = ray_.processed[processed + i];
      out.blended += entry.blended;
      if (!learning_ || !hits_.rules().sorted()) continue;
      gaussian_made_[hits[i].made] = entry.gaussian;
      if (hits[i].owner != 0) gaussian_of_[hits[i].owner - 1] = entry.gaussian;
    }
    out.packed = out_.take();
    if (!round.overflow) return;
    checkpoints_.drop_written();
    hits_.drop_evictions();
  }

  // Events.

  /// t_max: after the event.
  void take(const Event& event, float t_max, RayRound& out) {
    const EventKind kind = event.kind();
    const bool t_max_changes = values_ != nullptr && t_max != t_max_;
    out_.byte(static_cast<unsigned>(kind) | (kind == EventKind::visit_internal ? 0u : unsigned{event.detail} << 3) |
              (kind != EventKind::visit_internal && event.written() != 0 ? 0x40u : 0u) | (t_max_changes ? 0x80u : 0u));
    switch (kind) {
      case EventKind::visit_internal:
        ++out.visits[0];
        visit_internal(event, out);
        break;
      case EventKind::visit_instance:
        ++out.visits[1];
        visit_instance(event);
        break;
      case EventKind::visit_leaf:
        ++out.visits[2];
        ++out.outcomes[event.detail];
        visit_leaf(event, out);
        break;
      case EventKind::cull:
        checkpoint(pop(event), event.checkpoints, out);
        break;
      case EventKind::replay_take:
      case EventKind::replay_forward:
        read_source(event, out);
        break;
    }
    if (!t_max_changes) return;
    t_max_ = t_max;
    out_.time(t_max_);
  }

  void visit_internal(const Event& event, RayRound& out) {
    const NodeEntry popped = pop(event);
    const std::uint32_t first = nodes_[popped.node].first_child - 1;
    std::vector<NodeEntry> children, written;
    out_.byte(static_cast<unsigned>(children_[event_].size()));
    for (const std::uint32_t child : children_[event_]) {
      const unsigned slot = nodes_.slot(number_of(events_[child]));
      out_.byte(slot);
      children.push_back({first + slot, popped.instance, popped.object});
    }
    out_.byte(event.checkpoints);
    for (unsigned slot = 0; slot < traces::kMaxWidth; ++slot) {
      if ((event.checkpoints >> slot & 1) != 0) written.push_back({first + slot, popped.instance, popped.object});
    }
    for (std::vector<NodeEntry>* const list : {&children, &written}) {
      for (NodeEntry& entry : *list) {
        entry.t = next_time();
        out_.time(entry.t);
      }
    }
    for (const NodeEntry& entry : children) push(entry);
    for (const NodeEntry& entry : written) checkpoint(entry, 1, out);
  }

  void visit_instance(const Event& event) {
    if (event.detail != 0) return out_.number(number_of(event));
    const NodeEntry popped = pop(event);
    const std::uint32_t below = levels_.root_below(event.node);
    const bool blas = below == traces::InstanceLevels::kBlasRoot;
    const std::uint32_t number = blas ? root(header_.blas_root) : nodes_.number(levels_.object_root(below));
    out_.number(number);
    push({number, blas ? popped.node + 1 : 0, blas ? popped.object : popped.node + 1, popped.t});
  }

  void visit_leaf(const Event& event, RayRound& out) {
    NodeEntry popped = pop(event);
    const LeafOutcome outcome = event.outcome();
    if (outcome == LeafOutcome::miss) return;
    popped.t = next_time();
    out_.time(popped.t);
    HitEntry hit{popped.instance != 0 ? popped.instance : popped.node + 1, popped.object, 0, popped.t, made_++};
    hit.gaussian = gaussian_of(hit);
    if (values_ != nullptr && hit.gaussian != 0) result_.met.insert(hit.gaussian - 1);
    checkpoint(popped, event.written(), out);

    const std::vector<HitEntry>& hits = hits_.k_buffer().entries();
    const char* const broken = hits_.rules().broken_by(outcome, event.shifts(), hits.size(), true);
    require(broken == nullptr, broken);
    const bool forgets = traces::replaces(outcome) && !hits_.rules().sorted() && values_ == nullptr;
    if (forgets) hits_.forget([] { return HitEntry(); });  // the trace does not tell which one is replaced
    const std::uint64_t held = traces::RoundRules::held_after(outcome, hits.size());
    const auto places = hits_.take(hit, {outcome, event.shifts(), event.hidden()}, place_of_last());
    if (traces::replaces(outcome)) out_.number(forgets ? 1 : places.out == kNobody ? 0 : places.out + 2);
    if (!traces::enters(outcome)) return;
    require(event.hidden() < held, "a hit hides entries of the k-buffer, but not the one that ends the ray");
    out_.number(places.in);
    if (header_.opacity_bound == traces::OpacityBound::on) out_.number(event.hidden());
    if (!hits_.rules().sorted()) out_.number(event.shifts());
  }

  /// Place of the k-buffer's last hit.
  std::size_t place_of_last() const {
    const std::vector<HitEntry>& hits = hits_.k_buffer().entries();
    if (hits_.rules().sorted()) return hits.size() - 1;
    return static_cast<std::size_t>(std::max_element(hits.begin(), hits.end()) - hits.begin());
  }

  void read_source(const Event& event, RayRound& out) {
    const traces::ReadOrder& order = checkpoints_.order();
    const std::size_t read = checkpoints_.reads();
    const std::size_t place = order.by_place() ? order.position(read, source_.size()) : places_[read];
    out_.number(place);
    const NodeEntry entry = source_.at(place);
    checkpoints_.read_from(place);
    if (event.kind() == EventKind::replay_take) {
      ++out.taken;
      place_ = stack_.size();
      push(entry);
    } else {
      ++out.forwarded;
      checkpoint(entry, event.checkpoints, out);
    }
  }

  void checkpoint(const NodeEntry& entry, unsigned kept, RayRound& out) {
    if (kept == 0) return;
    ++out.written;
    checkpoints_.write(entry, checkpoints_.has_bins() ? ray_.bins.at(next_bin_++) : 0u);
  }

  // The stack, the topmost entry last.

  /// Takes the event's node from the top of the stack; with several nodes under way from anywhere in it.
  NodeEntry pop(const Event& event) {
    place_ = find(number_of(event));
    out_.number(from_top(place_));
    const NodeEntry entry = stack_[place_];
    stack_.erase(stack_.begin() + static_cast<std::ptrdiff_t>(place_));
    return entry;
  }
  /// Pushes an entry where the last one popped was, below those that were pushed there since.
  void push(const NodeEntry& entry) { stack_.insert(stack_.begin() + static_cast<std::ptrdiff_t>(place_), entry); }
  std::size_t find(std::uint32_t number) const {
    std::size_t place = stack_.size();
    while (place > 0 && stack_[place - 1].node != number) --place;
    require(place > 0 && (place == stack_.size() || header_.ahead > 1), "the node must be on the stack");
    return place - 1;
  }
  std::size_t from_top(std::size_t place) const { return stack_.size() - 1 - place; }

  // Facts of the trace.

  std::uint32_t number_of(const Event& event) const { return nodes_.number(units_of(group_, event)); }
  std::uint32_t root(std::uint64_t address) const {
    return nodes_.number(static_cast<std::uint32_t>(address / header_.node_sizes().unit()));
  }
  float next_time() { return values_ == nullptr ? kUnknownTime : values_->times[time_++]; }
  HitEntry unknown_hit() {
    HitEntry hit;
    hit.made = made_++;
    const auto known = gaussian_made_.find(hit.made);
    if (known != gaussian_made_.end()) hit.gaussian = known->second + 1;
    return hit;
  }
  std::uint32_t gaussian_of(const HitEntry& hit) const {
    const std::uint32_t local = nodes_[hit.owner - 1].gaussian;
    if (local != kNoGaussian)
      return (hit.object == 0 || values_ == nullptr ? 0 : nodes_[hit.object - 1].gaussian) + local + 1;
    const auto known = gaussian_of_.find(hit.owner - 1);
    return known == gaussian_of_.end() ? 0 : known->second + 1;
  }

  const std::string& file_;
  const traces::Header& header_;
  const traces::RayGroup& group_;
  const unsigned lane_;
  const traces::Ray& ray_;
  const RayNodes& nodes_;
  const traces::InstanceLevels levels_;
  const RayValues* values_;

  bool learning_ = true;
  std::span<const Event> events_;                         ///< of the round
  std::vector<std::vector<std::uint32_t>> children_;      ///< of the round: children_of()
  std::size_t event_ = kNobody;                           ///< the event of the round that is replayed
  std::map<std::uint32_t, std::uint32_t> gaussian_made_;  ///< HitEntry::made -> Gaussian
  std::map<std::uint32_t, std::uint32_t> gaussian_of_;    ///< owner -> Gaussian

  std::vector<NodeEntry> stack_;
  std::size_t place_ = 0;  ///< on the stack: where the next entry is pushed
  traces::RoundHits<HitEntry> hits_;
  traces::CheckpointLists<NodeEntry> checkpoints_;
  std::vector<NodeEntry> source_;  ///< entries that the round may read
  std::size_t next_bin_ = 0;       ///< index into the ray's checkpoint bins
  float t_max_ = kUnknownTime;
  std::uint32_t made_ = 0;
  std::size_t time_ = 0;  ///< index into RayValues::times
  std::vector<std::uint32_t> places_;
  traces::SourceAssignment assignment_;
  PackedRound out_;
  ReplayedRay result_;
};

}  // namespace

ReplayedRay replay_ray(const std::string& file, const traces::Header& header, const traces::RayGroup& group,
                       unsigned lane, const RayNodes& nodes, const RayValues* values) {
  return Replay(file, header, group, lane, nodes, values).run();
}

}  // namespace grtx::report
