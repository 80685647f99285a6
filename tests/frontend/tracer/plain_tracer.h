// SPDX-License-Identifier: Apache-2.0
// A second implementation of multi-round tracing, from docs/model/tracer.md: one ray after the other, every box and
// leaf tested anew, buffers as plain lists. It shares with the tracer what is not its matter: the node image, boxes
// against rays, and the canonical hit. When a ray ends by its transmittance it takes from the trace.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/gaussian/canonical_hit.h"
#include "grtx/frontend/gaussian/gaussian_math.h"
#include "grtx/frontend/tracer/tracer_options.h"
#include "grtx/traces/event.h"

namespace grtx::test {

class PlainTracer {
 public:
  struct Event {
    traces::EventKind kind;
    std::uint64_t address;
    unsigned detail, checkpoints;
    friend bool operator==(const Event&, const Event&) = default;
  };
  struct Round {
    bool replay = false, overflow = false;
    std::size_t preloaded = 0;
    std::vector<Event> events;
    std::vector<std::uint32_t> k_buffer;  ///< Gaussians, front to back
  };

  PlainTracer(const frontend::PreparedGaussians& gaussians, const frontend::AccelerationStructure& accel,
              const frontend::TracerOptions& options)
      : gaussians_(gaussians), accel_(accel), image_(accel.image()), options_(options) {}

  void begin_ray(const frontend::TraceRay& ray, float limit) {
    ray_ = ray;
    limit_ = limit;
    last_ = {-1.0f, 0};
    light_ = 1.0f;
    alpha_.clear();
    evicted_.clear();
    destination_.clear();
    overflow_ = true;  // the first round starts at the root
  }

  Round round() {
    round_ = {};
    round_.replay = options_.checkpoint && !overflow_;
    std::vector<Node> source;
    if (round_.replay) source = destination_;
    destination_.clear();
    overflow_ = false;
    std::sort(evicted_.begin(), evicted_.end());
    nearest_.clear();
    while (nearest_.size() < options_.k && !evicted_.empty() && !ends_within()) {
      nearest_.push_back(evicted_.front());
      evicted_.erase(evicted_.begin());
    }
    round_.preloaded = nearest_.size();
    end_at_opacity();
    t_max_ = limit_;
    if (!round_.replay) {
      walk({accel_.root(), traces::NodeKind::internal, 0.0f, 0});
    } else {
      if (options_.checkpoint_order == traces::CheckpointOrder::lifo) std::reverse(source.begin(), source.end());
      if (options_.checkpoint_order == traces::CheckpointOrder::nearest) {
        std::stable_sort(source.begin(), source.end(), [](const Node& a, const Node& b) { return a.t < b.t; });
      }
      for (const Node& node : source) {
        if (node.t > t_max_) {
          note(traces::EventKind::replay_forward, node.address, 0, checkpoint(node));
          continue;
        }
        note(traces::EventKind::replay_take, node.address, 0, 0);
        if (node.instance != 0) note(traces::EventKind::visit_instance, node.instance, 1, 0);
        walk(node);
      }
    }
    for (const auto& [event, entry] : queue_) round_.events[event].detail = static_cast<unsigned>(any_hit(entry));
    queue_.clear();
    round_.overflow = overflow_;
    if (overflow_) {
      evicted_.clear();
      destination_.clear();
    }
    for (const HitEntry& hit : nearest_) {
      round_.k_buffer.push_back(hit.second);
      light_ *= 1.0f - alpha_[hit.second];
    }
    if (!nearest_.empty()) last_ = nearest_.back();
    return round_;
  }

 private:
  struct Node {
    std::uint64_t address;
    traces::NodeKind kind;
    float t;
    std::uint64_t instance;  ///< leaf through which a node of the BLAS was reached; 0: none
  };
  using HitEntry = std::pair<float, std::uint32_t>;  ///< t, Gaussian

  void note(traces::EventKind kind, std::uint64_t address, unsigned detail, unsigned checkpoints) {
    round_.events.push_back({kind, address, detail, checkpoints});
  }
  unsigned checkpoint(const Node& node) {
    if (!options_.checkpoint || overflow_ || node.t > limit_) return 0;
    if (destination_.size() == options_.checkpoint_capacity) {
      overflow_ = true;
      return 0;
    }
    destination_.push_back(node);
    return 1;
  }
  std::uint32_t gaussian_of_instance(std::uint64_t leaf) const {
    return image_.leaf_index(static_cast<std::uint32_t>(leaf / traces::kNodeUnit));
  }

  /// Last in, first out; a child that is followed at once is handled before anything is popped.
  void walk(const Node& first) {
    if (options_.ahead > 1) return walk_ahead(first);
    std::vector<Node> stack;
    std::deque<Node> followed = {first};
    while (!followed.empty() || !stack.empty()) {
      Node node{};
      if (!followed.empty()) {
        node = followed.front();
        followed.pop_front();
      } else {
        node = stack.back();
        stack.pop_back();
        if (options_.pop_test == frontend::PopTest::on && node.t > t_max_) {
          note(traces::EventKind::cull, node.address, 0, checkpoint(node));
          continue;
        }
      }
      if (node.kind == traces::NodeKind::instance) {
        note(traces::EventKind::visit_instance, node.address, 0, 0);
        followed.push_back({accel_.blas_root(), traces::NodeKind::internal, node.t, node.address});
      } else if (node.kind == traces::NodeKind::internal) {
        open(node, stack, followed);
      } else {
        leaf(node);
      }
    }
  }

  /// Several nodes under way: the stack as a map from paths, whose order is depth first.
  void walk_ahead(const Node& first) {
    using Path = std::vector<unsigned>;
    struct UnderWay {
      Node node{};
      unsigned started = 0;
    };
    std::map<Path, UnderWay> stack;
    stack[{}] = {first, 0};
    std::map<Path, Event> events;
    unsigned started = 0;
    while (!stack.empty()) {
      auto under_way =
          std::count_if(stack.begin(), stack.end(), [](const auto& entry) { return entry.second.started != 0; });
      for (auto entry = stack.begin(); entry != stack.end() && under_way < options_.ahead;) {
        UnderWay& next = entry->second;
        if (next.started == 0 && options_.pop_test == frontend::PopTest::on && next.node.t > t_max_) {
          events[entry->first] = {traces::EventKind::cull, next.node.address, 0, 0};
          entry = stack.erase(entry);
          continue;
        }
        if (next.started == 0) next.started = ++started, ++under_way;
        ++entry;
      }
      auto oldest = stack.end();
      for (auto entry = stack.begin(); entry != stack.end(); ++entry) {
        if (entry->second.started == 0) continue;
        if (oldest == stack.end() || entry->second.started < oldest->second.started) oldest = entry;
      }
      if (oldest == stack.end()) continue;
      const auto [path, done] = *oldest;
      stack.erase(oldest);
      std::vector<Node> pushed;
      std::deque<Node> followed;
      done.node.kind == traces::NodeKind::internal ? open(done.node, pushed, followed) : leaf(done.node);
      events[path] = round_.events.back();
      round_.events.pop_back();
      std::reverse(pushed.begin(), pushed.end());
      pushed.insert(pushed.begin(), followed.begin(), followed.end());
      for (unsigned rank = 0; rank < pushed.size(); ++rank) {
        Path child = path;
        child.push_back(rank);
        stack[child] = {pushed[rank], 0};
      }
    }
    for (const auto& [path, event] : events) round_.events.push_back(event);
  }

  void open(const Node& parent, std::vector<Node>& stack, std::deque<Node>& followed) {
    const frontend::DecodedInternal node = image_.decode_internal(parent.address);
    frontend::SlabRay slabs = ray_.slabs;
    float offset = 0.0f;
    if (parent.instance != 0) {
      const auto unit = frontend::to_unit_ray(ray_, gaussians_.record(gaussian_of_instance(parent.instance)));
      slabs = frontend::SlabRay(unit.peak, unit.direction);
      offset = unit.t_peak;
    }
    struct Reached {
      Node node;
      unsigned slot;
    };
    std::vector<Reached> reached;
    unsigned checkpoints = 0;
    std::uint64_t address = node.child_base;
    for (unsigned slot = 0; slot < node.child_count; ++slot) {
      const frontend::Interval raw = frontend::slab_interval(slabs, node.boxes[slot]);
      const float enter = std::max(raw.enter + offset, 0.0f) * (1.0f - frontend::kSlabSlack);
      const float exit = (raw.exit + offset) * (1.0f + frontend::kSlabSlack);
      const Node child{address, node.kinds[slot], enter, parent.instance};
      address += traces::node_bytes(node.kinds[slot], image_.width());
      if (!(enter <= exit) || !(exit >= std::max(last_.first, 0.0f))) continue;
      if (enter > t_max_) {
        checkpoints |= checkpoint(child) << slot;
      } else {
        reached.push_back({child, slot});
      }
    }
    unsigned pushed = 0;
    for (const Reached& r : reached) pushed |= 1u << r.slot;
    note(traces::EventKind::visit_internal, parent.address, pushed, checkpoints);
    switch (options_.child_order) {
      case frontend::ChildOrder::near_first:
        std::stable_sort(reached.begin(), reached.end(),
                         [](const Reached& a, const Reached& b) { return a.node.t < b.node.t; });
        std::reverse(reached.begin(), reached.end());
        break;
      case frontend::ChildOrder::slot:
        std::reverse(reached.begin(), reached.end());
        break;
      case frontend::ChildOrder::vulkan_sim:
        break;
    }
    for (const Reached& r : reached) {
      const bool follow = options_.child_order == frontend::ChildOrder::vulkan_sim && followed.empty() &&
                          r.node.kind == traces::NodeKind::internal;
      if (follow) {
        followed.push_back(r.node);
      } else {
        stack.push_back(r.node);
      }
    }
  }

  void leaf(const Node& node) {
    using traces::LeafOutcome;
    const auto outcome = [&](LeafOutcome o, unsigned checkpoints = 0) {
      note(traces::EventKind::visit_leaf, node.address, static_cast<unsigned>(o), checkpoints);
    };
    const std::uint32_t primitive = image_.leaf_index(static_cast<std::uint32_t>(node.address / traces::kNodeUnit));
    const frontend::Proxy& proxy = accel_.proxy();
    const std::uint32_t faces = proxy.is_sphere() ? 1 : static_cast<std::uint32_t>(proxy.faces());
    const bool instanced = node.instance != 0;
    const std::uint32_t gaussian = instanced ? gaussian_of_instance(node.instance) : primitive / faces;
    const std::uint32_t face = instanced ? primitive : primitive % faces;
    const auto unit = frontend::to_unit_ray(ray_, gaussians_.record(gaussian));
    const frontend::Hit hit =
        frontend::canonical_hit(ray_, unit, gaussians_, gaussian, proxy, options_.sort_key, options_.inside,
                                frontend::face_test(frontend::SimdPath::portable));
    if (hit.kind != frontend::HitKind::hit || hit.face != face) return outcome(LeafOutcome::miss);
    const HitEntry entry{hit.t, gaussian};
    const frontend::GaussianRecord& record = gaussians_.record(gaussian);
    alpha_[gaussian] = frontend::hit_alpha(record.opacity, record.kappa2, hit.d2, options_.kernel.degree);
    if (entry.first < last_.first) return outcome(LeafOutcome::behind);
    if (entry > last_ && hit.t > t_max_)
      return outcome(LeafOutcome::beyond, checkpoint({node.address, node.kind, hit.t, node.instance}));
    if (options_.any_hit == frontend::AnyHit::delayed) {
      queue_.emplace_back(round_.events.size(), entry);
      return outcome(LeafOutcome::miss);  // until its turn comes
    }
    const LeafOutcome taken = any_hit(entry);
    const bool entered = taken == LeafOutcome::inserted || taken == LeafOutcome::displaced;
    outcome(taken, entered ? end_at_opacity() : 0);
  }

  /// log2(x) in steps of 1/1024, of x rounded up to the next mantissa of eight bits; rounded up.
  static int steps_above(float x) {
    int exponent = 0;
    const double mantissa = 2.0 * std::frexp(static_cast<double>(x), &exponent);  // 1 .. 2
    const double next = (std::floor(mantissa * 256.0) + 1.0) / 256.0;
    const double steps = 1024.0 * std::log2(next);
    return 1024 * (exponent - 1) + (next == 2.0 ? 1024 : static_cast<int>(std::floor(steps)) + 1);
  }
  /// The k-buffer's entries, from the nearest, at which the ray ends; 0: it goes on behind them.
  std::size_t ends_within() const {
    if (options_.opacity_bound == frontend::OpacityBound::off) return 0;
    int steps = steps_above(light_ / options_.ert);
    for (std::size_t i = 0; i < nearest_.size(); ++i) {
      steps -= std::max(0, -steps_above(1.0f - alpha_.at(nearest_[i].second)));
      if (steps <= 0) return i + 1;
    }
    return 0;
  }
  /// Moves the end of the ray there; returns how many entries leave.
  unsigned end_at_opacity() {
    const std::size_t within = ends_within();
    if (within == 0) return 0;
    const auto hidden = static_cast<unsigned>(nearest_.size() - within);
    nearest_.resize(within);
    limit_ = std::min(limit_, nearest_.back().first);
    t_max_ = std::min(t_max_, limit_);
    return hidden;
  }

  traces::LeafOutcome any_hit(const HitEntry& entry) {
    using traces::LeafOutcome;
    if (entry <= last_) return LeafOutcome::ignored;
    const bool kth = options_.tmax_update == frontend::TmaxUpdate::kth && options_.any_hit != frontend::AnyHit::delayed;
    if (nearest_.size() < options_.k) {
      nearest_.insert(std::upper_bound(nearest_.begin(), nearest_.end(), entry), entry);
      if (kth && nearest_.size() == options_.k) t_max_ = nearest_.back().first;
      return LeafOutcome::inserted;
    }
    if (entry < nearest_.back()) {
      if (options_.checkpoint) evicted_.push_back(nearest_.back());
      nearest_.pop_back();
      nearest_.insert(std::upper_bound(nearest_.begin(), nearest_.end(), entry), entry);
      if (kth) t_max_ = nearest_.back().first;
      return LeafOutcome::displaced;
    }
    if (options_.checkpoint) evicted_.push_back(entry);
    t_max_ = kth ? nearest_.back().first : entry.first;
    return LeafOutcome::rejected;
  }

  const frontend::PreparedGaussians& gaussians_;
  const frontend::AccelerationStructure& accel_;
  const frontend::NodeImage& image_;
  const frontend::TracerOptions options_;
  frontend::TraceRay ray_;
  float limit_ = 0.0f, t_max_ = 0.0f;
  float light_ = 1.0f;                    ///< transmittance when the round begins
  std::map<std::uint32_t, float> alpha_;  ///< of the Gaussians that the ray has hit
  HitEntry last_;                         ///< blended last
  std::vector<HitEntry> nearest_, evicted_;
  std::vector<std::pair<std::size_t, HitEntry>> queue_;  ///< hits of delayed any-hit shaders, and their events
  std::vector<Node> destination_;
  bool overflow_ = true;
  Round round_;
};

}  // namespace grtx::test
