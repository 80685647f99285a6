// Traces one ray: rounds, traversal of the node image, k-buffer, eviction buffer, checkpoint and replay, blending.
// docs/model/tracer.md states the semantics; every decision the hardware model replays is taken here.
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/accel/multi_object.h"
#include "grtx/frontend/gaussian/canonical_hit.h"
#include "grtx/frontend/gaussian/gaussian_math.h"
#include "grtx/frontend/gaussian/response_precision.h"
#include "grtx/frontend/gaussian/world_triangle.h"
#include "grtx/frontend/scene/scene.h"
#include "grtx/frontend/tracer/k_buffer.h"
#include "grtx/frontend/tracer/node_intersection.h"
#include "grtx/frontend/tracer/ray_recorder.h"
#include "grtx/frontend/tracer/ray_walk.h"
#include "grtx/frontend/tracer/tracer_counters.h"
#include "grtx/frontend/tracer/tracer_options.h"
#include "grtx/frontend/tracer/visit_tracker.h"
#include "grtx/frontend/tracer/walk_memory.h"

namespace grtx::frontend {

struct RayResult {
  glm::vec3 colour{0.0f};
  float transmittance = 1.0f;
};

/// The Gaussians of the object that a ray is in.
class CurrentGaussians {
 public:
  explicit CurrentGaussians(const PreparedGaussians& gaussians) : gaussians_(&gaussians) {}
  const GaussianRecord& record(std::uint32_t g) const { return gaussians_->record(g); }
  void prefetch_record(std::uint32_t g) const { __builtin_prefetch(&gaussians_->record(g)); }
  operator const PreparedGaussians&() const { return *gaussians_; }

 private:
  const PreparedGaussians* gaussians_;
};

/// One a thread; holds the buffers of the ray being traced. Blended (id) sequences can be observed through `on_blend`.
class RayTracer {
 public:
  RayTracer(const Scene& scene, const PreparedGaussians& gaussians, const AccelerationStructure& accel,
            const TracerOptions& options)
      : scene_(scene),
        gaussians_(gaussians),
        root_(static_cast<std::uint32_t>(accel.root() / traces::kNodeUnit)),
        blas_root_(static_cast<std::uint32_t>(accel.blas_root() / traces::kNodeUnit)),
        image_(accel.image()),
        layout_(accel.image().layout()),
        proxy_(accel.proxy()),
        options_(options),
        faces_(accel.proxy().is_sphere() ? 1 : accel.proxy().faces()),
        test_children_(node_test(options.simd, layout_.slots)),
        test_faces_(face_test(options.simd)),
        k_buffer_(options.k),
        root_box_(box_of_root()),
        walk_(image_, walk_kernels(options.simd, layout_.slots)) {
    if (options.triangle_test == TriangleTest::world) processed_by_.resize(scene.size());
  }

  /// Several objects by three-level instancing; Gaussian ids are those of the whole scene. For the NullRecorder only:
  /// the trace format knows one level of instances.
  RayTracer(const MultiObjectWorld& world, const TracerOptions& options)
      : scene_(world.objects().front()->scene),
        gaussians_(world.objects().front()->gaussians),
        root_(static_cast<std::uint32_t>(world.root() / traces::kNodeUnit)),
        blas_root_(static_cast<std::uint32_t>(world.blas_root() / traces::kNodeUnit)),
        image_(world.image()),
        layout_(world.image().layout()),
        proxy_(world.proxy()),
        options_(options),
        faces_(world.proxy().is_sphere() ? 1 : world.proxy().faces()),
        world_(&world),
        test_children_(node_test(options.simd, layout_.slots)),
        test_faces_(face_test(options.simd)),
        k_buffer_(options.k),
        root_box_(box_of_root()),
        walk_(image_, walk_kernels(options.simd, layout_.slots)) {}

  const TracerCounters& counters() const { return counters_; }
  void track_visits(VisitTracker* tracker) { tracker_ = tracker; }
  /// When set, receives the ids blended by the rays traced from now on.
  void collect_blended(std::vector<std::uint32_t>* ids) { blended_ids_ = ids; }

  /// The light that reaches the ray's origin from hits with t <= t_limit, dimmed by `transmittance` (what lies before
  /// the origin left), and the transmittance that remains. Nothing beyond t_limit is pushed or checkpointed.
  template <typename Recorder>
  RayResult trace(const TraceRay& ray, Recorder& recorder, float transmittance = 1.0f,
                  float t_limit = std::numeric_limits<float>::infinity());

 private:
  /// On the stack and in checkpoint buffers. Numbers are indices into the walk's memory; 0 is the root.
  struct Entry {
    float t = 0.0f;  ///< conservative entry t, or t_hit of a leaf beyond t_max
    std::uint32_t node = 0;
    std::uint32_t packed = 0;    ///< the node's kind, slot and link, as they were when it was pushed
    std::uint32_t instance = 0;  ///< TLAS leaf; 0 for nodes outside the BLAS
    std::uint32_t object = 0;    ///< leaf of the scene TLAS; 0 in that TLAS and in scenes of one object
  };

  /// The traversal stack. Grows ahead of a node's children, so that pushing checks nothing.
  class Stack {
   public:
    bool empty() const { return size_ == 0; }
    void clear() { size_ = 0; }
    Entry pop() { return entries_[--size_]; }
    void push(const Entry& e) {
      *top() = e;
      ++size_;
    }
    /// Where the next entries go: room for eight. set_top() tells behind the last one written.
    Entry* top() {
      if (size_ + traces::kMaxWidth > entries_.size()) entries_.resize(2 * entries_.size());
      return entries_.data() + size_;
    }
    void set_top(const Entry* end) { size_ = static_cast<std::size_t>(end - entries_.data()); }

   private:
    std::vector<Entry> entries_ = std::vector<Entry>(512);
    std::size_t size_ = 0;
  };

  const std::uint8_t* bytes(std::uint32_t units) const {
    return image_.node(static_cast<std::uint64_t>(units) * traces::kNodeUnit);
  }
  bool in_blas(const Entry& e) const { return e.instance != 0; }
  void push_root(std::uint32_t node, float t, std::uint32_t instance, std::uint32_t object) {
    stack_.push({t, node, memory_[node].packed, instance, object});
  }
  std::uint32_t units_of(std::uint32_t node) { return memory_[node].node; }
  Box box_of_root() const {
    const DecodedInternal root = image_.decode_internal(static_cast<std::uint64_t>(root_) * traces::kNodeUnit);
    Box box;
    for (unsigned i = 0; i < root.child_count; ++i) box.extend(root.boxes[i]);
    return box;
  }
  bool skips(Skip skip) const { return options_.skips.has(skip); }

  template <typename Recorder>
  void miss_scene(Recorder& recorder);
  template <typename Recorder>
  void trace_round(const TraceRay& ray, Recorder& recorder);
  template <typename Recorder>
  bool begin_ray(const TraceRay& ray, Recorder& recorder, float transmittance, float t_limit);
  template <typename Recorder>
  traces::Round begin_round(Recorder& recorder);
  template <typename Recorder>
  bool end_round(const TraceRay& ray, traces::Round& round, Recorder& recorder);
  void walk_round(const TraceRay& ray);
  bool can_walk_lists() const;
  void walk_leaf(const TraceRay& ray);
  void take_hit(std::uint32_t link);
  template <typename Recorder>
  void drain_stack(const TraceRay& ray, Recorder& recorder);
  template <typename Recorder>
  void visit_internal(const TraceRay& ray, const Entry& entry, Recorder& recorder);
  std::uint32_t test_boxes(const TraceRay& ray, std::uint32_t node, bool blas);
  unsigned checkpoint_children(const Entry& parent, std::uint32_t list, unsigned mask);
  template <typename Recorder>
  void visit_leaf(const TraceRay& ray, const Entry& entry, Recorder& recorder);
  template <typename Recorder>
  void blend(const TraceRay& ray, traces::Round& round, Recorder& recorder);

  glm::vec3 colour_of(const KEntry& entry, const GaussianRecord& g, const TraceRay& ray);
  /// Of the basis that is evaluated: all bands that the tracer knows unless it skips those above the scene's.
  unsigned sh_degree() const { return skips(Skip::sh_bands) ? scene_.sh_degree : std::max(3u, scene_.sh_degree); }
  void enter_instance(const TraceRay& ray, std::uint32_t leaf);
  std::uint32_t test_leaf(const TraceRay& ray, const Entry& entry);
  std::uint32_t link_of_primitive(const TraceRay& ray, std::uint32_t primitive);
  std::uint32_t link_of_hit(Hit hit, std::uint32_t gaussian);
  const Hit& hit_of_instance(const TraceRay& ray);
  template <typename Recorder>
  void decide_instance(const TraceRay& ray, const Entry& entry, Recorder& recorder);
  template <typename Recorder>
  void offer(std::uint32_t link, const Entry& entry, Recorder& recorder);
  /// primitive / faces_: a division by 5 as a multiplication, exact for all 32 bits, then a shift.
  std::uint32_t gaussian_of(std::uint32_t primitive) const {
    return static_cast<std::uint32_t>(std::uint64_t{primitive} * (faces_ == 1 ? 1u : 0xCCCCCCCDu) >> faces_shift_);
  }
  ShearedRay object_space_ray(const TraceRay& ray, std::uint32_t gaussian) const;
  // Several objects.
  void enter_object(const TraceRay& ray, std::uint32_t leaf);
  void place_hit(Hit& hit, std::uint32_t& gaussian) const;
  glm::vec3 colour_in_world(const KEntry& entry, const TraceRay& ray) const;
  /// The ray in the space of the entry's node.
  const TraceRay& local_ray(const TraceRay& ray, const Entry& entry) {
    if (entry.object == 0) return ray;
    if (entry.object != object_) enter_object(ray, entry.object);
    return object_ray_;
  }
  const Hit& hit_of(const TraceRay& ray, std::uint32_t gaussian);
  Hit world_hit(const TraceRay& ray, const Entry& entry, std::uint32_t gaussian, std::uint32_t face);
  struct AnyHit {
    traces::LeafOutcome outcome;
    unsigned shifts;  ///< entries of the k-buffer that moved
  };
  std::optional<traces::LeafOutcome> blended_before(const KEntry& hit);
  AnyHit any_hit(const KEntry& hit);
  template <typename Recorder>
  void collect_unsorted(const KEntry& candidate, const Entry& entry, Recorder& recorder);
  template <typename Recorder>
  void commit_nearest(const KEntry& candidate, const Entry& entry, Recorder& recorder);
  void count_doubled(std::uint32_t gaussian);
  void refill_from_evictions(traces::Round& round);
  void visited(std::uint32_t units, unsigned size_units) {
    if (tracker_ != nullptr) tracker_->visit(units, size_units);
  }

  /// Writes an entry to the destination buffer; false when it is dropped (checkpointing off, overflow, or
  /// beyond the end of the ray).
  bool checkpoint(const Entry& entry) {
    if (!options_.checkpoint || overflow_ || entry.t > t_limit_) return false;
    if (destination_.size() == options_.checkpoint_capacity) {
      overflow_ = true;
      return false;
    }
    destination_.push_back(entry);
    ++counters_.checkpoints_written;
    return true;
  }

  const Scene& scene_;
  CurrentGaussians gaussians_;
  const std::uint32_t root_;       ///< units
  const std::uint32_t blas_root_;  ///< units
  const NodeImage& image_;
  const InternalLayout layout_;
  const Proxy& proxy_;
  const TracerOptions options_;
  const unsigned faces_;                                                   ///< 1, 20 or 80
  const unsigned faces_shift_ = faces_ == 1 ? 0 : faces_ == 20 ? 36 : 38;  ///< see gaussian_of()
  const bool remember_ = options_.skips.has(Skip::retests);
  /// Rounding to 16 bits may lift an alpha to the threshold.
  const bool skip_never_accepted_ =
      options_.skips.has(Skip::never_accepted) && options_.response_precision == ResponsePrecision::fp32;
  /// A structure of stored triangles must be walked: which of them are hit is for their vertices to say.
  const bool skip_blas_ = options_.skips.has(Skip::blas) && options_.triangle_test == TriangleTest::canonical;
  const MultiObjectWorld* world_ = nullptr;
  const NodeTest test_children_;
  const FaceTest test_faces_;

  // State of the ray.
  float t_last_ = -1.0f;
  std::uint32_t id_last_ = 0;
  float t_min_cull_ = 0.0f;  ///< boxes that end before this hold nothing new
  float t_max_ = 0.0f;
  float t_limit_ = 0.0f;  ///< end of the ray: t_max of its first round; nothing beyond it is kept
  bool replay_ = false;
  bool overflow_ = false;
  float transmittance_ = 1.0f;
  glm::vec3 colour_{0.0f};
  std::array<float, kShFunctions> basis_{};
  glm::vec3 unused_colour_{0.0f};  ///< of hits behind the end of a ray, when they are not skipped
  KBuffer k_buffer_;
  const Box root_box_;  ///< holds the decoded boxes of the root's children
  std::vector<KEntry> evictions_;
  Stack stack_;
  std::vector<Entry> source_;
  std::vector<Entry> destination_;

  WalkMemory memory_;
  /// In its place, but for the hits, where can_walk_lists() and nobody asks for events.
  RayWalk walk_;
  const bool walks_lists_ = can_walk_lists();
  std::uint32_t instance_ = 0;  ///< the instance being walked, link into memory_

  // The object being walked, with several.
  std::uint32_t object_ = 0;  ///< leaf of the scene TLAS, index into memory_
  const PlacedObject* placed_ = nullptr;
  TraceRay object_ray_;
  Interval object_interval_;  ///< of the ray in the object's world box

  // Recent hit tests of a monolithic structure: up to 80 faces of a Gaussian lie close together in the walk.
  struct CachedHit {
    std::uint64_t tag = ~std::uint64_t{0};
    Hit hit;
  };
  static constexpr std::size_t kHitCache = 512;
  std::vector<CachedHit> hit_cache_ = std::vector<CachedHit>(kHitCache);
  std::uint64_t ray_stamp_ = 0;

  // Tests against stored vertices (options_.triangle_test).
  ShearedRay sheared_;
  std::vector<std::uint64_t> processed_by_;  ///< a Gaussian's last ray_stamp_; empty unless the test is `world`

  bool turned_away_ = false;  ///< single: a hit of this round met a full buffer

  TracerCounters counters_;
  VisitTracker* tracker_ = nullptr;
  std::vector<std::uint32_t>* blended_ids_ = nullptr;
};

template <typename Recorder>
RayResult RayTracer::trace(const TraceRay& ray, Recorder& recorder, float transmittance, float t_limit) {
  if (!begin_ray(ray, recorder, transmittance, t_limit)) return {colour_, transmittance_};
  const std::uint64_t visits_before = counters_.visits();
  traces::Round round;
  do {
    round = begin_round(recorder);
    trace_round(ray, recorder);
  } while (end_round(ray, round, recorder));
  if (!Recorder::kEnabled) counters_.skipped_events += counters_.visits() - visits_before;
  return {colour_, transmittance_};
}

/// False: the ray misses the scene, and that is all.
template <typename Recorder>
bool RayTracer::begin_ray(const TraceRay& ray, Recorder& recorder, float transmittance, float t_limit) {
  t_last_ = -1.0f;
  id_last_ = 0;
  replay_ = false;
  transmittance_ = transmittance;
  t_limit_ = t_limit;
  colour_ = glm::vec3(0.0f);
  if (options_.sh_direction == ShDirection::ray) basis_ = sh_basis(ray.direction, sh_degree());
  evictions_.clear();
  source_.clear();
  memory_.clear();
  memory_.add({0.0f, std::numeric_limits<float>::infinity(), root_, NodeKind::internal, 0});
  if (walks_lists_) walk_.begin_ray(root_);
  ++ray_stamp_;
  if (options_.triangle_test == TriangleTest::world) sheared_ = ShearedRay(ray.origin, ray.direction);
  object_ = 0;
  ++counters_.rays;
  if (tracker_ != nullptr) tracker_->begin_ray();
  if (!skips(Skip::scene_miss) || !conservative_interval(ray.slabs, root_box_).empty()) return true;
  miss_scene(recorder);
  return false;
}

template <typename Recorder>
traces::Round RayTracer::begin_round(Recorder& recorder) {
  traces::Round round;
  round.replay = replay_;
  ++counters_.rounds;
  k_buffer_.clear();
  destination_.clear();
  overflow_ = false;
  turned_away_ = false;
  recorder.begin_round(replay_);
  refill_from_evictions(round);
  t_max_ = t_limit_;
  if (options_.replay_tmax == ReplayTmax::kth && k_buffer_.full()) t_max_ = k_buffer_.back().t;
  // The peak of a polyhedron's Gaussian may lie beyond its entry face's box, so only entry keys allow this cull.
  t_min_cull_ = options_.sort_key == SortKey::entry ? std::max(t_last_, 0.0f) : 0.0f;
  return round;
}

/// Blends what the round has found. False: it was the ray's last.
template <typename Recorder>
bool RayTracer::end_round(const TraceRay& ray, traces::Round& round, Recorder& recorder) {
  counters_.evictions_max_per_ray = std::max<std::uint64_t>(counters_.evictions_max_per_ray, evictions_.size());
  round.overflow = overflow_;
  round.k_count = static_cast<std::uint16_t>(k_buffer_.size());
  if (options_.tracing == Tracing::single) k_buffer_.sort();
  if (turned_away_) ++counters_.single_overflows;
  blend(ray, round, recorder);
  counters_.checkpoints_max_per_ray = std::max<std::uint64_t>(counters_.checkpoints_max_per_ray, destination_.size());
  if (overflow_) {
    ++counters_.checkpoint_overflows;
    round.eviction_dropped = static_cast<std::uint32_t>(evictions_.size());
    evictions_.clear();
    destination_.clear();
  }
  recorder.end_round(round);
  if (round.terminated) ++counters_.terminated;
  if (round.terminated || !k_buffer_.full()) return false;
  t_last_ = k_buffer_.back().t;
  id_last_ = k_buffer_.back().id;
  source_.swap(destination_);
  replay_ = options_.checkpoint && !overflow_;
  return true;
}

/// What such a ray does: it visits the root, hits no child, and its only round ends without a hit.
template <typename Recorder>
void RayTracer::miss_scene(Recorder& recorder) {
  ++counters_.skipped_scene_misses;
  ++counters_.rounds;
  ++counters_.visits_internal;
  visited(root_, layout_.slots == 6 ? 1 : 2);
  recorder.begin_round(false);
  recorder.pop();
  recorder.internal(recorder.open(root_), root_, 0, 0);
  recorder.end_round({});
}

template <typename Recorder>
void RayTracer::trace_round(const TraceRay& ray, Recorder& recorder) {
  if (!Recorder::kEnabled && walks_lists_) return walk_round(ray);
  stack_.clear();
  if (!replay_) {
    stack_.push({0.0f, 0, memory_[0].packed, 0, 0});
    drain_stack(ray, recorder);
    return;
  }
  if (options_.checkpoint_order == CheckpointOrder::lifo) {
    std::reverse(source_.begin(), source_.end());
  } else if (options_.checkpoint_order == CheckpointOrder::nearest) {
    std::stable_sort(source_.begin(), source_.end(), [](const Entry& a, const Entry& b) { return a.t < b.t; });
  }
  for (const Entry& entry : source_) {
    ++counters_.checkpoints_read;
    if (entry.t > t_max_) {
      const bool kept = checkpoint(entry);
      recorder.event(traces::EventKind::replay_forward, units_of(entry.node), 0, kept ? 1 : 0);
      continue;
    }
    recorder.event(traces::EventKind::replay_take, units_of(entry.node), 0, 0);
    if (entry.object != 0) {
      ++counters_.visits_instance;
      visited(units_of(entry.object), 2);
    }
    if (in_blas(entry)) {
      // The ray must be transformed again before a BLAS node can be tested.
      ++counters_.visits_instance;
      visited(units_of(entry.instance), 2);
      recorder.event(traces::EventKind::visit_instance, units_of(entry.instance), 1, 0);
      enter_instance(local_ray(ray, entry), entry.instance);
    }
    stack_.push({entry.t, entry.node, memory_[entry.node].packed, entry.instance, entry.object});
    drain_stack(ray, recorder);
  }
}

template <typename Recorder>
void RayTracer::drain_stack(const TraceRay& ray, Recorder& recorder) {
  while (!stack_.empty()) {
    const Entry entry = stack_.pop();
    recorder.pop();
    if (entry.t > t_max_) {
      const bool kept = checkpoint(entry);
      recorder.event(traces::EventKind::cull, units_of(entry.node), 0, kept ? 1 : 0);
      continue;
    }
    switch (ReachedNode::kind_of(entry.packed)) {
      case NodeKind::internal:
        visit_internal(local_ray(ray, entry), entry, recorder);
        break;
      case NodeKind::instance: {
        ++counters_.visits_instance;
        visited(units_of(entry.node), 2);
        recorder.event(traces::EventKind::visit_instance, units_of(entry.node), 0, 0);
        if (world_ != nullptr && entry.object == 0) {
          enter_object(ray, entry.node);
          push_root(memory_[entry.node].link(), entry.t, 0, entry.node);
          break;
        }
        enter_instance(local_ray(ray, entry), entry.node);
        if (skip_blas_) {
          decide_instance(local_ray(ray, entry), entry, recorder);
          break;
        }
        push_root(memory_.instance(instance_).root, entry.t, entry.node, entry.object);
        break;
      }
      default:
        if (ReachedNode::link_of(entry.packed) == WalkMemory::kMissed) {  // most leaves of later rounds
          ++counters_.visits_leaf;
          ++counters_.skipped_retests;
          visited(units_of(entry.node), 1);
          recorder.event(traces::EventKind::visit_leaf, units_of(entry.node),
                         static_cast<unsigned>(traces::LeafOutcome::miss), 0);
          break;
        }
        visit_leaf(local_ray(ray, entry), entry, recorder);
        break;
    }
  }
}

inline void RayTracer::enter_instance(const TraceRay& ray, std::uint32_t leaf) {
  instance_ = memory_[leaf].link();
  if (instance_ != 0) {
    ++counters_.skipped_retests;
    return;
  }
  instance_ = memory_.add_instance();
  if (remember_) memory_[leaf].set_link(instance_);
  EnteredInstance& instance = memory_.instance(instance_);
  instance.gaussian = image_.leaf_index(units_of(leaf));
  instance.unit = to_unit_ray(ray, gaussians_.record(instance.gaussian));
  instance.slabs = SlabRay(instance.unit.peak, instance.unit.direction);
  instance.root = memory_.add({0.0f, std::numeric_limits<float>::infinity(), blas_root_, NodeKind::internal, 0});
  if (options_.triangle_test == TriangleTest::world) instance.sheared = object_space_ray(ray, instance.gaussian);
}

/// Tests the boxes of a node's children; returns the list of those hit: its head, then the children, those to be
/// visited first in front.
inline std::uint32_t RayTracer::test_boxes(const TraceRay& ray, std::uint32_t node, bool blas) {
  const std::uint32_t units = units_of(node);
  const std::uint8_t* data = bytes(units);
  NodeHits hits;
  if (blas) {
    const EnteredInstance& instance = memory_.instance(instance_);
    test_children_(data, units, instance.slabs, {instance.unit.t_peak, t_min_cull_}, hits);
  } else {
    test_children_(data, units, ray.slabs, {0.0f, t_min_cull_}, hits);
  }
  if (!blas) image_.prefetch_children(hits.info.child_base);
  const std::uint32_t list = memory_.reserve(hits.count + 1);
  ReachedNode* const head = &memory_[list];
  head->node = hits.count;
  const bool near_first = options_.child_order == ChildOrder::near_first;
  std::ptrdiff_t in_slot_order = 0;
  for (unsigned rest = hits.hit; rest != 0; rest &= rest - 1) {
    const auto slot = static_cast<unsigned>(__builtin_ctz(rest));
    const std::uint32_t child = hits.info.child_base + child_offset(hits.info, slot);
    const auto kind = static_cast<NodeKind>(data[layout_.child_info + slot] >> 2);
    head[1 + (near_first ? hits.rank[slot] : in_slot_order++)] =
        ReachedNode(hits.enter[slot], hits.exit[slot], child, kind, slot);
  }
  if (remember_) memory_[node].set_link(list);
  return list;
}

template <typename Recorder>
void RayTracer::visit_internal(const TraceRay& ray, const Entry& entry, Recorder& recorder) {
  ++counters_.visits_internal;
  visited(units_of(entry.node), layout_.slots == 6 ? 1 : 2);
  std::uint32_t list = memory_[entry.node].link();
  if (list == 0) {
    list = test_boxes(ray, entry.node, in_blas(entry));
  } else {
    ++counters_.skipped_retests;
  }
  // The last of the list is pushed first, so that the nearest ends on top of the stack.
  const ReachedNode* const children = &memory_[list];
  const std::uint32_t count = children->node;
  Entry* top = stack_.top();
  const std::uint32_t units = Recorder::kEnabled ? units_of(entry.node) : 0;
  typename Recorder::Children opened = recorder.open(units);
  unsigned pushed = 0, beyond = 0;
  for (std::uint32_t i = count; i > 0; --i) {
    const ReachedNode& child = children[i];
    // Written without branches, which would follow no pattern.
    const unsigned alive = child.exit >= t_min_cull_ ? 1u : 0u;
    const unsigned within = child.enter <= t_max_ ? alive : 0u;
    *top = {child.enter, list + i, child.packed, entry.instance, entry.object};
    top += within;
    if (Recorder::kEnabled) pushed |= within << child.slot();
    opened.put(child.slot(), within);
    beyond |= (alive ^ within) << child.slot();
  }
  stack_.set_top(top);
  unsigned checkpoints = 0;
  if (beyond != 0 && options_.checkpoint) checkpoints = checkpoint_children(entry, list, beyond);
  recorder.internal(opened, units, pushed, checkpoints);
}

/// Checkpoints the children in `mask`, in slot order; returns the mask of those kept.
inline unsigned RayTracer::checkpoint_children(const Entry& parent, std::uint32_t list, unsigned mask) {
  std::uint32_t at[traces::kMaxWidth] = {};
  const std::uint32_t count = memory_[list].node;
  for (std::uint32_t i = 1; i <= count; ++i) at[memory_[list + i].slot()] = list + i;
  unsigned kept = 0;
  for (unsigned rest = mask; rest != 0; rest &= rest - 1) {
    const auto slot = static_cast<unsigned>(__builtin_ctz(rest));
    const ReachedNode& child = memory_[at[slot]];
    if (checkpoint({child.enter, at[slot], child.packed, parent.instance, parent.object})) kept |= 1u << slot;
  }
  return kept;
}

inline void RayTracer::enter_object(const TraceRay& ray, std::uint32_t leaf) {
  object_ = leaf;
  placed_ = &world_->placed()[image_.leaf_index(units_of(leaf))];
  gaussians_ = CurrentGaussians(placed_->object->gaussians);
  object_ray_ = placed_->to_object_ray(ray);
  object_interval_ = conservative_interval(ray.slabs, placed_->box);
  if (memory_[leaf].link() == 0) {
    const std::uint32_t root =
        memory_.add({0.0f, std::numeric_limits<float>::infinity(),
                     static_cast<std::uint32_t>(placed_->object->root / traces::kNodeUnit), NodeKind::internal, 0});
    memory_[leaf].set_link(root);
  }
}

// World and object space round differently. As with the boxes of a face, a hit is defined to lie in its object's world
// box: whatever the scene TLAS looks like, its boxes contain that one and lead to the hit.
inline void RayTracer::place_hit(Hit& hit, std::uint32_t& gaussian) const {
  gaussian += placed_->first_gaussian;
  if (object_interval_.empty()) hit.kind = HitKind::miss;
  hit.t = std::max(hit.t, object_interval_.enter);
  // The box may end before a peak, which is not an entry.
  if (options_.sort_key == SortKey::entry && hit.t > object_interval_.exit) hit.kind = HitKind::miss;
}

// Spherical harmonics are the object's: they turn with it because the direction is taken to its space.
inline glm::vec3 RayTracer::colour_in_world(const KEntry& entry, const TraceRay& ray) const {
  const PlacedObject& placed = world_->owner(entry.id);
  const std::uint32_t local = entry.id - placed.first_gaussian;
  const Scene& scene = placed.object->scene;
  const TraceRay object_ray = placed.to_object_ray(ray);
  const glm::vec3 d = options_.sh_direction == ShDirection::centre
                          ? placed.object->gaussians.record(local).mean - object_ray.origin
                          : object_ray.direction;
  const unsigned coefficients = scene.sh_coefficients();
  return sh_colour(&scene.sh[static_cast<std::size_t>(local) * coefficients * 3],
                   sh_basis(d / std::sqrt(glm::dot(d, d)), scene.sh_degree), coefficients);
}

inline const Hit& RayTracer::hit_of(const TraceRay& ray, std::uint32_t gaussian) {
  CachedHit& cached = hit_cache_[gaussian % kHitCache];
  const std::uint64_t tag = (ray_stamp_ << 32) | gaussian;
  if (cached.tag != tag) {
    cached.tag = tag;
    cached.hit = canonical_hit(ray, to_unit_ray(ray, gaussians_.record(gaussian)), gaussians_, gaussian, proxy_,
                               options_.sort_key, options_.inside, test_faces_);
  }
  return cached.hit;
}

/// Tests a leaf; returns what becomes its link.
inline std::uint32_t RayTracer::test_leaf(const TraceRay& ray, const Entry& entry) {
  const std::uint32_t primitive = image_.leaf_index(units_of(entry.node));
  std::uint32_t link = WalkMemory::kMissed;
  if (!in_blas(entry) && options_.triangle_test == TriangleTest::canonical) {
    link = link_of_primitive(ray, primitive);
  } else {
    const std::uint32_t gaussian = in_blas(entry) ? memory_.instance(instance_).gaussian : gaussian_of(primitive);
    const std::uint32_t face = in_blas(entry) ? primitive : primitive - gaussian * faces_;
    const Hit hit =
        options_.triangle_test == TriangleTest::world ? world_hit(ray, entry, gaussian, face) : hit_of_instance(ray);
    if (hit.face == face) link = link_of_hit(hit, gaussian);
  }
  if (remember_) memory_[entry.node].set_link(link);
  return link;
}

/// The same for a leaf of a monolithic structure, which holds one of all the scene's proxy faces.
inline std::uint32_t RayTracer::link_of_primitive(const TraceRay& ray, std::uint32_t primitive) {
  const std::uint32_t gaussian = gaussian_of(primitive);
  const Hit& hit = hit_of(ray, gaussian);
  return hit.face == primitive - gaussian * faces_ ? link_of_hit(hit, gaussian) : WalkMemory::kMissed;
}

inline std::uint32_t RayTracer::link_of_hit(Hit hit, std::uint32_t gaussian) {
  if (skip_never_accepted_ && gaussians_.record(gaussian).opacity < kAlphaMin) {
    ++counters_.skipped_never_accepted;
    return WalkMemory::kMissed;
  }
  if (world_ != nullptr) place_hit(hit, gaussian);
  if (hit.kind == HitKind::miss) return WalkMemory::kMissed;
  return hit.kind == HitKind::inside ? WalkMemory::kInside : memory_.add_hit({hit.t, gaussian, hit.d2});
}

inline const Hit& RayTracer::hit_of_instance(const TraceRay& ray) {
  EnteredInstance& instance = memory_.instance(instance_);
  if (!instance.hit_known) {
    instance.hit = canonical_hit(ray, instance.unit, gaussians_, instance.gaussian, proxy_, options_.sort_key,
                                 options_.inside, test_faces_);
    instance.hit_known = true;
  }
  return instance.hit;
}

/// In place of a walk of the BLAS: the hit that it would find.
template <typename Recorder>
void RayTracer::decide_instance(const TraceRay& ray, const Entry& entry, Recorder& recorder) {
  EnteredInstance& instance = memory_.instance(instance_);
  ++counters_.skipped_blas_walks;
  if (instance.decision == 0) instance.decision = link_of_hit(hit_of_instance(ray), instance.gaussian);
  offer(instance.decision, entry, recorder);
}

template <typename Recorder>
void RayTracer::visit_leaf(const TraceRay& ray, const Entry& entry, Recorder& recorder) {
  ++counters_.visits_leaf;
  visited(units_of(entry.node), 1);
  std::uint32_t link = memory_[entry.node].link();
  if (link == 0) {
    link = test_leaf(ray, entry);
  } else {
    ++counters_.skipped_retests;
  }
  offer(link, entry, recorder);
}

/// What follows from a leaf's test (`link`): the any-hit shader, a checkpoint, or nothing.
template <typename Recorder>
void RayTracer::offer(std::uint32_t link, const Entry& entry, Recorder& recorder) {
  using traces::EventKind;
  using traces::LeafOutcome;
  const auto outcome = [&](LeafOutcome o, unsigned checkpoints = 0, unsigned shifts = 0) {
    recorder.event(EventKind::visit_leaf, units_of(entry.node), static_cast<unsigned>(o), checkpoints, shifts);
  };
  if (link == WalkMemory::kMissed) return outcome(LeafOutcome::miss);
  if (link == WalkMemory::kInside) {
    if (t_last_ < 0.0f) ++counters_.inside_skipped;
    return outcome(LeafOutcome::miss);
  }
  const KEntry hit = memory_.hit(link);
  if (const auto before = blended_before(hit)) return outcome(*before);
  if (hit.t > t_max_) {
    const bool kept = checkpoint({hit.t, entry.node, entry.packed, entry.instance, entry.object});
    return outcome(LeafOutcome::beyond, kept ? 1 : 0);
  }
  if (options_.tracing == Tracing::single) return collect_unsorted(hit, entry, recorder);
  if (options_.tracing == Tracing::closest) return commit_nearest(hit, entry, recorder);
  const AnyHit result = any_hit(hit);
  outcome(result.outcome, 0, result.shifts);
}

/// The resume rule: the outcome of a hit that is not behind the last one blended.
inline std::optional<traces::LeafOutcome> RayTracer::blended_before(const KEntry& hit) {
  using traces::LeafOutcome;
  if (hit.t < t_last_) return LeafOutcome::behind;
  if (hit.t > t_last_) return std::nullopt;
  if (options_.resume == Resume::strict) {  // t_min < t fails: it never reaches the any-hit shader
    if (hit.id > id_last_) ++counters_.ties_lost;
    return LeafOutcome::behind;
  }
  if (hit.id > id_last_) return std::nullopt;
  if (options_.tracing == Tracing::closest) return LeafOutcome::behind;
  ++counters_.any_hit_ignored;
  return LeafOutcome::ignored;
}

/// The any-hit shader of multi-round tracing, for a hit up to t_max.
inline RayTracer::AnyHit RayTracer::any_hit(const KEntry& hit) {
  using traces::LeafOutcome;
  if (!k_buffer_.full()) {
    const unsigned shifts = k_buffer_.insert(hit);
    ++counters_.any_hit_inserted;
    if (options_.tmax_update == TmaxUpdate::kth && k_buffer_.full()) t_max_ = std::min(t_max_, k_buffer_.back().t);
    return {LeafOutcome::inserted, shifts};
  }
  ++counters_.any_hit_evicted;
  if (hit < k_buffer_.back()) {
    if (options_.checkpoint) evictions_.push_back(k_buffer_.back());
    const unsigned shifts = k_buffer_.displace(hit);
    ++counters_.any_hit_inserted;
    if (options_.tmax_update == TmaxUpdate::kth) t_max_ = std::min(t_max_, k_buffer_.back().t);
    return {LeafOutcome::displaced, shifts};
  }
  if (options_.checkpoint) evictions_.push_back(hit);
  ++counters_.any_hit_rejected;
  t_max_ = options_.tmax_update == TmaxUpdate::kth ? std::min(t_max_, k_buffer_.back().t) : hit.t;
  return {LeafOutcome::rejected, 0};
}

inline void RayTracer::refill_from_evictions(traces::Round& round) {
  if (evictions_.empty()) return;
  std::sort(evictions_.begin(), evictions_.end());
  const std::size_t moved = std::min<std::size_t>(options_.k, evictions_.size());
  for (std::size_t i = 0; i < moved; ++i) k_buffer_.append_sorted(evictions_[i]);
  evictions_.erase(evictions_.begin(), evictions_.begin() + static_cast<std::ptrdiff_t>(moved));
  round.preloaded = static_cast<std::uint16_t>(moved);
}

template <typename Recorder>
void RayTracer::blend(const TraceRay& ray, traces::Round& round, Recorder& recorder) {
  const unsigned coefficients = scene_.sh_coefficients();
  if (world_ == nullptr) {
    for (const KEntry& entry : k_buffer_.entries()) {
      const float* sh = &scene_.sh[static_cast<std::size_t>(entry.id) * coefficients * 3];
      __builtin_prefetch(sh);
      if (coefficients > 4) {
        __builtin_prefetch(sh + 16);
        __builtin_prefetch(sh + 32);
      }
    }
  }
  for (const KEntry& entry : k_buffer_.entries()) {
    const GaussianRecord& g = world_ != nullptr ? world_->record(entry.id) : gaussians_.record(entry.id);
    const float alpha = options_.response_precision == ResponsePrecision::fp32
                            ? hit_alpha(g.opacity, g.kappa2, entry.d2)
                            : hit_alpha_16(g.opacity, g.kappa2, entry.d2, options_.response_precision);
    recorder.processed(entry.id, alpha > 0.0f);
    ++round.processed_count;
    ++counters_.processed;
    if (options_.triangle_test == TriangleTest::world) count_doubled(entry.id);
    if (!(alpha > 0.0f)) continue;
    const glm::vec3 colour = colour_of(entry, g, ray);
    const float weight = alpha * transmittance_;
    colour_ += weight * colour;
    transmittance_ *= 1.0f - alpha;
    ++counters_.blended;
    if (blended_ids_ != nullptr) blended_ids_->push_back(entry.id);
    if (transmittance_ < options_.ert) {
      round.terminated = true;
      break;
    }
  }
  if (!round.terminated) return;
  for (std::size_t i = round.processed_count; i < k_buffer_.size(); ++i) {
    if (skips(Skip::dead_colours)) {
      ++counters_.skipped_dead_colours;
      continue;
    }
    const KEntry& entry = k_buffer_.entries()[i];
    unused_colour_ = colour_of(entry, world_ != nullptr ? world_->record(entry.id) : gaussians_.record(entry.id), ray);
  }
}

inline glm::vec3 RayTracer::colour_of(const KEntry& entry, const GaussianRecord& g, const TraceRay& ray) {
  if (world_ != nullptr) return colour_in_world(entry, ray);
  if (options_.sh_direction == ShDirection::centre) {
    const glm::vec3 to_centre = g.mean - ray.origin;
    basis_ = sh_basis(to_centre / std::sqrt(glm::dot(to_centre, to_centre)), sh_degree());
  }
  const unsigned coefficients = scene_.sh_coefficients();
  const float* sh = &scene_.sh[static_cast<std::size_t>(entry.id) * coefficients * 3];
  if (coefficients >= kShFunctions) return sh_colour(sh, basis_, coefficients);
  if (skips(Skip::sh_bands)) {
    counters_.skipped_sh_bands += 3 * (kShFunctions - coefficients);
    return sh_colour(sh, basis_, coefficients);
  }
  std::array<float, 3 * kShFunctions> padded{};  // the bands that the scene lacks, as zeros
  std::copy(sh, sh + 3 * coefficients, padded.begin());
  return sh_colour(padded.data(), basis_, kShFunctions);
}

}  // namespace grtx::frontend

#include "grtx/frontend/tracer/ray_tracer_lists.h"
#include "grtx/frontend/tracer/ray_tracer_modes.h"
