// SPDX-License-Identifier: Apache-2.0
// Legal traces of random trees: a small tracer in the space of hashes. Every node has, for every ray, a pseudo-random
// entry distance behind its parent's and hits or misses at random; everything else (stack, k-buffer, eviction and
// checkpoint buffers, rounds) follows the rules of the design, so that check() must accept the result.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <deque>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::traces::testing {

struct RandomOptions {
  std::uint32_t seed = 1;
  std::uint64_t groups = 3;
  unsigned warp_size = 8;
  unsigned bvh_width = 6;
  NodeLayout layout = NodeLayout::vulkan_sim;
  bool procedural = false;  ///< all primitive leaves
  unsigned depth = 3;       ///< levels of internal nodes at most
  unsigned k = 4;
  bool checkpoint = true;
  std::uint64_t capacity = 1000;
  CheckpointOrder checkpoint_order = CheckpointOrder::fifo;
  unsigned bins = 0;  ///< checkpoint bins of `capacity` entries each; 0: there are two buffers
  ChildOrder child_order = ChildOrder::near_first;
  PopTest pop_test = PopTest::on;
  bool two_level = false;
  unsigned objects = 0;  ///< with two_level: TLASes below a scene TLAS; 0: there is none
  bool blas_root_is_leaf = false;
  bool root_is_leaf = false;
  bool wide = false;                   ///< layout quantised: some of the coded leaves are wide
  Tracing tracing = Tracing::multi;    ///< all but multi need checkpoint = false; closest k = 1
  AnyHit any_hit = AnyHit::immediate;  ///< delayed needs multi and checkpoint = false; half of the rays then end early
  ErtCheck ert_check = ErtCheck::hit;
  ColourPer colour = ColourPer::hit;  ///< frame needs objects = 0; all groups are then of primary rays
};

struct RandomTrace {
  Header header;
  std::vector<RayGroup> groups;
};

/// The node image: a TLAS or monolithic tree, or a scene TLAS and those of the objects, then the BLAS.
class RandomTree {
 public:
  RandomTree(const RandomOptions& options, std::mt19937& random) : options_(options), random_(random) {
    const NodeKind primitive = options.procedural ? NodeKind::procedural : NodeKind::triangle;
    const NodeKind leaf = options.two_level ? NodeKind::instance : primitive;
    root_ = next_;
    if (options.root_is_leaf) {
      leaf_kinds_[root_] = leaf;
      next_ += units(leaf);
    } else {
      next_ += units(NodeKind::internal);
      grow(root_, options.depth, leaf);
    }
    if (!options.two_level) return;
    const std::uint32_t scene_end = next_;
    for (unsigned object = 0; object < options.objects; ++object) {
      object_roots_.push_back(++next_);  // behind a header
      next_ += units(NodeKind::internal);
      grow(object_roots_.back(), std::max(1U, options.depth - 1), leaf);
    }
    if (options.objects != 0) {
      for (const auto& [address, kind] : leaf_kinds_) {
        if (address < scene_end) scene_leaves_[address] = static_cast<std::uint32_t>(random_() % options.objects);
      }
    }
    wide_here_ = false;
    blas_base_ = next_++;
    blas_root_ = next_;
    if (options.blas_root_is_leaf) {
      leaf_kinds_[blas_root_] = NodeKind::procedural;
      next_ += units(NodeKind::procedural);
    } else {
      next_ += units(NodeKind::internal);
      grow(blas_root_, 2, primitive);
    }
  }

  const NodeDefinition* internal(std::uint32_t address) const {
    const auto found = internals_.find(address);
    return found == internals_.end() ? nullptr : &found->second;
  }
  NodeKind kind(std::uint32_t address) const {
    return internals_.contains(address) ? NodeKind::internal : leaf_kinds_.at(address);
  }
  std::uint32_t root() const { return root_; }
  std::uint32_t blas_base() const { return blas_base_; }
  std::uint32_t blas_root() const { return blas_root_; }
  std::uint32_t end() const { return next_; }
  const std::vector<std::uint32_t>& object_roots() const { return object_roots_; }
  const std::map<std::uint32_t, std::uint32_t>& scene_leaves() const { return scene_leaves_; }  ///< object by address
  std::uint64_t wide_leaves() const {
    std::uint64_t count = 0;
    for (const auto& [address, kind] : leaf_kinds_) count += is_wide(kind) ? 1 : 0;
    return count;
  }
  std::uint32_t units(NodeKind kind) const { return NodeSizes(options_.layout, options_.bvh_width).units(kind); }

 private:
  void grow(std::uint32_t address, unsigned depth, NodeKind leaf) {
    NodeDefinition node{.address = address,
                        .child_base = next_,
                        .child_count = static_cast<std::uint8_t>(2 + random_() % (options_.bvh_width - 1))};
    for (unsigned slot = 0; slot < node.child_count; ++slot) {
      const bool inner = depth > 1 && random_() % 3 != 0;
      NodeKind kind = leaf;
      // A structure has one kind of primitive leaf; where both have one size, any will do.
      if (leaf == NodeKind::triangle && random_() % 5 == 0 && options_.layout != NodeLayout::quantised) {
        kind = NodeKind::procedural;
      }
      if (wide_here_ && random_() % 4 == 0) kind = wide_kind(kind);
      if (inner) kind = NodeKind::internal;
      node.child_kinds[slot] = kind;
      if (!inner) leaf_kinds_[next_] = kind;
      next_ += units(node.child_kinds[slot]);
    }
    internals_[address] = node;
    std::uint32_t child = node.child_base;
    for (unsigned slot = 0; slot < node.child_count; ++slot) {
      if (node.child_kinds[slot] == NodeKind::internal) grow(child, depth - 1, leaf);
      child += units(node.child_kinds[slot]);
    }
  }

  const RandomOptions& options_;
  std::mt19937& random_;
  std::map<std::uint32_t, NodeDefinition> internals_;
  std::map<std::uint32_t, NodeKind> leaf_kinds_;
  std::vector<std::uint32_t> object_roots_;
  std::map<std::uint32_t, std::uint32_t> scene_leaves_;
  bool wide_here_ = options_.wide;
  std::uint32_t next_ = 1;  ///< the file header takes the first unit
  std::uint32_t root_ = 0;
  std::uint32_t blas_base_ = 0;
  std::uint32_t blas_root_ = 0;
};

/// Traces one ray of hashes. Internal nodes stand in the events by address until the group is complete.
class RandomRay {
 public:
  RandomRay(const RandomOptions& options, const RandomTree& tree, std::uint32_t ray_seed)
      : options_(options), tree_(tree), seed_(ray_seed), random_(ray_seed) {}

  Ray trace() {
    while (true) {
      const bool replay = options_.checkpoint && !ray_.rounds.empty() && !ray_.rounds.back().overflow;
      const Round round = trace_round(replay);
      ray_.rounds.push_back(round);
      if (round.k_count < options_.k || round.terminated) return ray_;
    }
  }

 private:
  struct Entry {
    std::uint32_t address;
    std::uint64_t t;
    std::uint32_t scene;     ///< leaf of the scene TLAS above; 0: none
    std::uint32_t instance;  ///< leaf above the BLAS; 0: none
    std::uint64_t context() const { return std::uint64_t{scene} << 32 | instance; }
  };
  struct Hit {
    std::uint64_t t;
    std::uint32_t gaussian;
    friend auto operator<=>(const Hit&, const Hit&) = default;
  };

  std::uint64_t hash(std::uint64_t address, std::uint64_t context, std::uint64_t salt) const {
    std::uint64_t x =
        seed_ * 0x9E3779B97F4A7C15ULL ^ address * 0xBF58476D1CE4E5B9ULL ^ context * 0x94D049BB133111EBULL ^ salt;
    for (int i = 0; i < 3; ++i) x = (x ^ x >> 29) * 0xD6E8FEB86659FD93ULL;
    return x >> 8;
  }

  void push_event(EventKind kind, std::uint32_t node, unsigned detail, unsigned checkpoints, unsigned shifts = 0) {
    Event event;
    event.node = node;
    event.detail = static_cast<std::uint8_t>(detail);
    event.checkpoints = static_cast<std::uint8_t>(checkpoints);
    event.kind_shifts = Event::pack(kind, shifts);
    const bool leaf = kind == EventKind::visit_leaf || kind == EventKind::visit_instance;
    if (leaf && is_wide(tree_.kind(node))) event.kind_shifts |= Event::kWide;
    ray_.events.push_back(event);
  }

  Round trace_round(bool replay) {
    Round round;
    round.replay = replay;
    begin_bins(replay);
    if (replay) round.bins = order_;
    const std::size_t first_event = ray_.events.size();
    source_ = replay ? destination_ : std::vector<Entry>{};
    destination_.clear();
    overflow_ = false;
    t_max_ = ~std::uint64_t{0};
    if (options_.any_hit == AnyHit::delayed && seed_ % 2 == 0) t_max_ = 1000 * (options_.depth - 1);
    k_buffer_.clear();
    std::sort(evictions_.begin(), evictions_.end());
    const std::size_t preload = std::min<std::size_t>(options_.k, evictions_.size());
    k_buffer_.assign(evictions_.begin(), evictions_.begin() + static_cast<std::ptrdiff_t>(preload));
    evictions_.erase(evictions_.begin(), evictions_.begin() + static_cast<std::ptrdiff_t>(preload));
    round.preloaded = static_cast<std::uint16_t>(preload);

    stack_.clear();
    if (!replay) stack_.push_back({tree_.root(), 0, 0, 0});
    while (true) {
      if (!stack_.empty()) {
        const Entry top = stack_.back();
        stack_.pop_back();
        handle(top);
      } else if (!source_.empty()) {
        const auto next = next_of_source();
        const Entry entry = *next;
        source_.erase(next);
        read_source(entry);
      } else if (!to_read_.empty()) {
        if (random_() % 8 == 0) break;  // it stays, and the rest with it
        std::deque<Entry>& bin = bins_[to_read_.front()];
        to_read_.pop_front();
        const Entry entry = bin.front();
        bin.pop_front();
        read_source(entry);
      } else {
        break;
      }
    }
    round.event_count = static_cast<std::uint32_t>(ray_.events.size() - first_event);
    round.overflow = overflow_;
    if (overflow_) {
      round.eviction_dropped = static_cast<std::uint32_t>(evictions_.size());
      evictions_.clear();
    }
    if (collects_unsorted(options_.tracing)) std::sort(k_buffer_.begin(), k_buffer_.end());
    blend(round);
    return round;
  }

  void blend(Round& round) {
    round.k_count = static_cast<std::uint16_t>(k_buffer_.size());
    round.terminated = !k_buffer_.empty() && random_() % 6 == 0;
    round.processed_count = round.k_count;
    if (round.terminated && options_.ert_check == ErtCheck::hit)
      round.processed_count = static_cast<std::uint16_t>(1 + random_() % round.k_count);
    for (std::size_t i = 0; i < round.processed_count; ++i) {
      Processed entry{.gaussian = k_buffer_[i].gaussian & 0x7FFFFFFFU, .blended = random_() % 4 != 0};
      ray_.processed.push_back(entry);
      t_last_ = k_buffer_[i].t;
    }
  }

  bool write(const Entry& entry) {
    if (!options_.checkpoint || overflow_) return false;
    if (options_.bins != 0) return write_to_bin(entry);
    if (destination_.size() == options_.capacity) {
      overflow_ = true;
      return false;
    }
    destination_.push_back(entry);
    return true;
  }

  // Bins in plain words: a queue each, for stretches of distance, the last one for all beyond them; what was in them
  // when the round began may be read, in any order.
  void begin_bins(bool replay) {
    if (options_.bins == 0) return;
    if (!replay) bins_.assign(options_.bins + 1, {});
    order_ = {static_cast<std::uint8_t>(random_() % options_.bins),
              static_cast<std::uint8_t>(random_() % (options_.bins + 1))};
    to_read_.clear();
    for (unsigned i = 0; i < options_.bins; ++i) {
      if (i == order_.before_far) to_read_.insert(to_read_.end(), bins_[options_.bins].size(), options_.bins);
      const unsigned bin = (order_.first + i) % options_.bins;
      to_read_.insert(to_read_.end(), bins_[bin].size(), bin);
    }
    if (order_.before_far == options_.bins) {
      to_read_.insert(to_read_.end(), bins_[options_.bins].size(), options_.bins);
    }
  }
  bool write_to_bin(const Entry& entry) {
    const unsigned bin =
        static_cast<unsigned>(std::min<std::uint64_t>(entry.t / 500 % (options_.bins + 3), options_.bins));
    if (bins_[bin].size() == options_.capacity) {
      overflow_ = true;
      return false;
    }
    bins_[bin].push_back(entry);
    ray_.bins.push_back(static_cast<std::uint8_t>(bin));
    return true;
  }

  std::vector<Entry>::iterator next_of_source() {
    auto next = source_.begin();
    if (options_.checkpoint_order == CheckpointOrder::lifo) next = source_.end() - 1;
    if (options_.checkpoint_order == CheckpointOrder::nearest) {
      next = std::min_element(source_.begin(), source_.end(), [](const Entry& a, const Entry& b) { return a.t < b.t; });
    }
    return next;
  }

  void read_source(const Entry& entry) {
    if (entry.t > t_max_) {
      push_event(EventKind::replay_forward, entry.address, 0, write(entry) ? 1 : 0);
      return;
    }
    push_event(EventKind::replay_take, entry.address, 0, 0);
    if (entry.scene != 0) push_event(EventKind::visit_instance, entry.scene, 1, 0);
    if (entry.instance != 0) push_event(EventKind::visit_instance, entry.instance, 1, 0);
    stack_.push_back(entry);
  }

  void handle(const Entry& top) {
    if (options_.pop_test == PopTest::on && top.t > t_max_) {
      push_event(EventKind::cull, top.address, 0, write(top) ? 1 : 0);
      return;
    }
    switch (without_width(tree_.kind(top.address))) {
      case NodeKind::internal:
        return handle_internal(top);
      case NodeKind::instance:
        push_event(EventKind::visit_instance, top.address, 0, 0);
        if (const auto leaf = tree_.scene_leaves().find(top.address); leaf != tree_.scene_leaves().end()) {
          stack_.push_back({tree_.object_roots()[leaf->second], top.t, top.address, 0});
        } else {
          stack_.push_back({tree_.blas_root(), top.t, top.scene, top.address});
        }
        return;
      default:
        return handle_leaf(top);
    }
  }

  void handle_internal(const Entry& top) {
    const NodeDefinition& node = *tree_.internal(top.address);
    std::vector<std::pair<Entry, unsigned>> pushed;
    unsigned pushed_mask = 0;
    unsigned checkpoint_mask = 0;
    std::uint32_t address = node.child_base;
    for (unsigned slot = 0; slot < node.child_count; ++slot) {
      const Entry child{address, top.t + hash(address, top.context(), 1) % 1000, top.scene, top.instance};
      address += tree_.units(node.child_kinds[slot]);
      if (hash(child.address, top.context(), 2) % 10 >= 8) continue;  // box missed
      if (child.t > t_max_) {
        if (write(child)) checkpoint_mask |= 1U << slot;
      } else {
        pushed.emplace_back(child, slot);
        pushed_mask |= 1U << slot;
      }
    }
    push_event(EventKind::visit_internal, top.address, pushed_mask, checkpoint_mask);
    if (options_.child_order == ChildOrder::near_first) {
      std::sort(pushed.begin(), pushed.end(), [](const auto& a, const auto& b) { return a.first.t > b.first.t; });
    } else if (options_.child_order == ChildOrder::slot) {
      std::reverse(pushed.begin(), pushed.end());
    } else {  // the first internal child is followed, and so comes last
      const auto followed = std::find_if(pushed.begin(), pushed.end(), [&](const auto& child) {
        return node.child_kinds[child.second] == NodeKind::internal;
      });
      if (followed != pushed.end()) std::rotate(followed, followed + 1, pushed.end());
    }
    for (const auto& [child, slot] : pushed) stack_.push_back(child);
  }

  void handle_leaf(const Entry& top) {
    const std::uint64_t t_hit = top.t + hash(top.address, top.context(), 3) % 1000;
    const std::uint32_t gaussian = top.instance != 0 ? top.instance : top.address / 2;  // a shared one now and then
    if (hash(top.address, top.context(), 4) % 10 >= 8) return leaf(top, LeafOutcome::miss);
    if (t_hit > t_max_) {
      push_event(EventKind::visit_leaf, top.address, static_cast<unsigned>(LeafOutcome::beyond), write(top) ? 1 : 0);
      return;
    }
    if (!ray_.rounds.empty() && t_hit <= t_last_) return leaf(top, LeafOutcome::behind);
    if (options_.tracing == Tracing::closest) return commit_nearest(top, {t_hit, gaussian});
    for (const Hit& hit : k_buffer_) {
      if (hit.gaussian == gaussian) return leaf(top, LeafOutcome::ignored);
    }
    const Hit hit{t_hit, gaussian};
    if (collects_unsorted(options_.tracing)) return collect_unsorted(top, hit);
    const auto place = std::upper_bound(k_buffer_.begin(), k_buffer_.end(), hit);
    auto shifts = static_cast<unsigned>(k_buffer_.end() - place);
    if (k_buffer_.size() < options_.k) {
      k_buffer_.insert(place, hit);
      return leaf(top, LeafOutcome::inserted, shifts);
    }
    if (place == k_buffer_.end()) {
      if (options_.checkpoint) evictions_.push_back(hit);
      if (options_.any_hit == AnyHit::immediate) t_max_ = t_hit;
      return leaf(top, LeafOutcome::rejected);
    }
    --shifts;  // the last one does not move, it falls out
    k_buffer_.insert(place, hit);
    if (options_.checkpoint) evictions_.push_back(k_buffer_.back());
    k_buffer_.pop_back();
    leaf(top, LeafOutcome::displaced, shifts);
  }

  void commit_nearest(const Entry& top, const Hit& hit) {
    if (!k_buffer_.empty() && !(hit < k_buffer_[0])) return leaf(top, LeafOutcome::beyond);
    k_buffer_.assign(1, hit);
    t_max_ = hit.t;
    leaf(top, LeafOutcome::nearest);
  }

  // How many entries a heap moves depends on its layout; here any legal number will do.
  void collect_unsorted(const Entry& top, const Hit& hit) {
    const std::uint64_t moves = hash(top.address, top.context(), 5);
    if (k_buffer_.size() < options_.k) {
      k_buffer_.push_back(hit);
      const bool filled = k_buffer_.size() == options_.k;
      return leaf(top, LeafOutcome::inserted, filled ? static_cast<unsigned>(moves % options_.k) : 0);
    }
    const auto largest = std::max_element(k_buffer_.begin(), k_buffer_.end());
    if (hit < *largest) {
      *largest = hit;
      return leaf(top, LeafOutcome::displaced, static_cast<unsigned>(moves) % std::bit_width(options_.k));
    }
    t_max_ = hit.t;
    leaf(top, LeafOutcome::rejected);
  }

  void leaf(const Entry& top, LeafOutcome outcome, unsigned shifts = 0) {
    push_event(EventKind::visit_leaf, top.address, static_cast<unsigned>(outcome), 0, shifts);
  }

  const RandomOptions& options_;
  const RandomTree& tree_;
  std::uint64_t seed_;
  std::mt19937 random_;
  Ray ray_;
  std::vector<Entry> stack_;
  std::vector<Entry> source_;
  std::vector<Entry> destination_;
  std::vector<std::deque<Entry>> bins_;
  std::deque<unsigned> to_read_;  ///< bins of the entries that this round may read
  BinOrder order_;
  std::vector<Hit> k_buffer_;
  std::vector<Hit> evictions_;
  std::uint64_t t_max_ = 0;
  std::uint64_t t_last_ = 0;
  bool overflow_ = false;
};

/// Collects the dictionary and replaces addresses in visit_internal events by indices.
inline void fill_dictionary(const RandomTree& tree, RayGroup& group) {
  std::map<std::uint32_t, std::uint32_t> index;
  for (const Ray& ray : group.rays) {
    for (const Event& event : ray.events) {
      if (event.kind() == EventKind::visit_internal) index[event.node] = 0;
    }
  }
  for (auto& [address, place] : index) {
    place = static_cast<std::uint32_t>(group.nodes.size());
    group.nodes.push_back(*tree.internal(address));
  }
  for (Ray& ray : group.rays) {
    for (Event& event : ray.events) {
      if (event.kind() == EventKind::visit_internal) event.node = index.at(event.node);
    }
  }
}

inline RandomTrace random_trace(const RandomOptions& options) {
  std::mt19937 random(options.seed);
  const RandomTree tree(options, random);
  RandomTrace trace;
  Header& header = trace.header;
  header.accel = options.two_level ? AccelKind::tlas_tri20 : AccelKind::tri20;
  header.tracing = options.tracing;
  header.k = options.k;
  header.checkpoint = options.checkpoint;
  header.checkpoint_order = options.checkpoint_order;
  header.checkpoint_bins = options.bins;
  header.child_order = options.child_order;
  header.pop_test = options.pop_test;
  header.any_hit = options.any_hit;
  header.ert_check = options.ert_check;
  header.colour = options.colour;
  header.width = 640;
  header.height = 480;
  header.warp_size = options.warp_size;
  header.groups = options.groups;
  header.bvh_width = options.bvh_width;
  header.layout = options.layout;
  header.wide_leaves = tree.wide_leaves();
  const std::uint64_t unit = header.node_sizes().unit();
  header.node_image_bytes = tree.end() * unit;
  header.root = tree.root() * unit;
  header.two_level = options.two_level;
  header.blas_base = tree.blas_base() * unit;
  header.blas_root = tree.blas_root() * unit;
  header.blas_bytes = options.two_level ? (tree.end() - tree.blas_base()) * unit : 0;
  header.blas_root_is_leaf = options.blas_root_is_leaf;
  for (const std::uint32_t root : tree.object_roots()) header.object_roots.push_back(root * unit);
  for (const auto& [address, object] : tree.scene_leaves()) header.scene_leaves.push_back({address * unit, object});
  header.gaussians = tree.end();
  header.sh_degree = 3;
  header.sh_record_bytes = sh_record_bytes(header.layout, header.sh_degree);
  header.checkpoint_capacity = options.checkpoint ? options.capacity : 0;
  header.inputs = {{"scene", "0123456789abcdef"}, {"camera", "view 3 of \"cameras\""}};
  for (std::uint64_t g = 0; g < options.groups; ++g) {
    RayGroup group;
    group.index = static_cast<std::uint32_t>(g);
    group.kind = static_cast<RayKind>(random() % 3);
    if (options.colour == ColourPer::frame) group.kind = RayKind::primary;
    group.rays.resize(1 + random() % options.warp_size);
    for (Ray& ray : group.rays) {
      if (random() % 8 != 0) ray = RandomRay(options, tree, static_cast<std::uint32_t>(random())).trace();
      ray.pixel = static_cast<std::uint32_t>(random() % (640 * 480));
    }
    fill_dictionary(tree, group);
    trace.groups.push_back(std::move(group));
  }
  return trace;
}

/// One line for test names and failure messages.
inline std::string describe(const RandomOptions& o) {
  return "seed " + std::to_string(o.seed) + (o.two_level ? " two-level" : " monolithic") +
         (o.objects != 0 ? " of " + std::to_string(o.objects) + " objects" : "") +
         (o.blas_root_is_leaf ? " leaf BLAS" : "") + (o.root_is_leaf ? " leaf root" : "") +
         (o.wide ? " wide leaves" : "") + " width " + std::to_string(o.bvh_width) + " " +
         std::string(grtx::name_of(o.layout)) + " k " + std::to_string(o.k) +
         (o.checkpoint ? " checkpoint " : " restart ") + std::string(grtx::name_of(o.checkpoint_order)) + " capacity " +
         std::to_string(o.capacity) + (o.bins != 0 ? " in " + std::to_string(o.bins) + " bins" : "") + " " +
         std::string(grtx::name_of(o.child_order)) + " " + (o.pop_test == PopTest::on ? "" : "no pop test ") +
         std::string(grtx::name_of(o.tracing)) + (o.any_hit == AnyHit::delayed ? " delayed" : "") +
         (o.ert_check == ErtCheck::round ? " tested once a round" : "") +
         (o.colour == ColourPer::frame ? " colours once" : "");
}

/// Every combination that changes how a group is coded.
inline std::vector<RandomOptions> all_random_options() {
  std::vector<RandomOptions> all;
  std::uint32_t seed = 100;
  for (const bool two_level : {false, true}) {
    for (const auto order : {CheckpointOrder::fifo, CheckpointOrder::lifo, CheckpointOrder::nearest}) {
      for (const auto child_order : {ChildOrder::near_first, ChildOrder::slot}) {
        for (const std::uint64_t capacity :
             {std::uint64_t{0}, std::uint64_t{5}, std::uint64_t{12}, std::uint64_t{1000}}) {
          for (const unsigned width : {2U, 6U, 8U}) {
            RandomOptions o;
            o.seed = ++seed;
            o.two_level = two_level;
            o.blas_root_is_leaf = two_level && seed % 3 == 0;
            o.root_is_leaf = seed % 17 == 0;
            o.checkpoint_order = order;
            o.child_order = child_order;
            o.checkpoint = capacity != 0;
            o.capacity = capacity;
            o.bvh_width = width;
            o.depth = width == 2 ? 6 : 3;
            o.k = 1 + seed % 7;
            all.push_back(o);
          }
        }
      }
    }
    for (const auto tracing : {Tracing::single, Tracing::closest}) {
      for (const auto child_order : {ChildOrder::near_first, ChildOrder::slot}) {
        for (const unsigned k : {1U, 4U, 100U}) {
          RandomOptions o;
          o.seed = ++seed;
          o.two_level = two_level;
          o.checkpoint = false;
          o.child_order = child_order;
          o.tracing = tracing;
          o.k = o.tracing == Tracing::closest ? 1 : k;
          all.push_back(o);
        }
      }
    }
  }
  // Each once more with what version 4 of the format does not have.
  for (std::size_t i = 0, count = all.size(); i < count; ++i) {
    RandomOptions o = all[i];
    o.seed = ++seed;
    if (i % 3 != 0) o.child_order = ChildOrder::vulkan_sim;
    o.pop_test = i % 3 != 1 ? PopTest::off : PopTest::on;
    all.push_back(o);
  }
  // Each two-level one once more below a scene TLAS.
  for (std::size_t i = 0, count = all.size(); i < count; ++i) {
    RandomOptions o = all[i];
    if (!o.two_level) continue;
    o.seed = ++seed;
    o.objects = 1 + seed % 3;
    o.depth = o.bvh_width == 2 ? 4 : o.bvh_width == 6 ? 2 : 1;  // three trees deep, a ray visits many nodes
    all.push_back(o);
  }
  // Bins in place of two buffers, behind them.
  for (const bool two_level : {false, true}) {
    for (const unsigned bins : {2U, 3U, 8U, 32U}) {
      for (const std::uint64_t capacity : {std::uint64_t{1}, std::uint64_t{5}, std::uint64_t{1000}}) {
        RandomOptions o{.seed = ++seed, .two_level = two_level};
        o.objects = two_level && o.seed % 3 == 0 ? 2 : 0;
        o.depth = o.objects != 0 ? 2 : 3;
        o.bins = bins;
        o.capacity = capacity;
        o.child_order = static_cast<ChildOrder>(o.seed % 3);
        o.k = 1 + o.seed % 7;
        all.push_back(o);
      }
    }
  }
  // Lists, likewise.
  for (const bool two_level : {false, true}) {
    for (const unsigned capacity : {1U, 4U, 100U}) {
      RandomOptions o{.seed = ++seed, .two_level = two_level, .objects = two_level && capacity == 4 ? 2u : 0u};
      o.depth = o.objects != 0 ? 2 : 3;
      o.checkpoint = false;
      o.child_order = static_cast<ChildOrder>(o.seed % 3);
      o.pop_test = o.seed % 2 == 0 ? PopTest::on : PopTest::off;
      o.tracing = Tracing::list;
      o.k = capacity;
      all.push_back(o);
    }
  }
  // Delayed any-hit shaders, likewise, and rays whose end is tested once per round.
  for (const bool two_level : {false, true}) {
    for (const unsigned k : {1U, 3U, 8U}) {
      for (const ErtCheck check : {ErtCheck::hit, ErtCheck::round}) {
        RandomOptions o{.seed = ++seed, .two_level = two_level, .objects = two_level && k == 3 ? 2u : 0u};
        o.depth = o.objects != 0 ? 2 : 3;
        o.child_order = static_cast<ChildOrder>(o.seed % 3);
        o.pop_test = o.seed % 2 == 0 ? PopTest::on : PopTest::off;
        o.k = k;
        o.ert_check = check;
        o.checkpoint = check == ErtCheck::round && k == 3;
        if (!o.checkpoint) o.any_hit = AnyHit::delayed;
        all.push_back(o);
      }
    }
  }
  all.push_back({.seed = ++seed, .colour = ColourPer::frame});
  return all;
}

}  // namespace grtx::traces::testing
