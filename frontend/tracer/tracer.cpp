// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/tracer/tracer.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/global_control.h>

#include <chrono>
#include <optional>
#include <stdexcept>

#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/base/progress.h"
#include "grtx/frontend/tracer/encoding_recorder.h"
#include "grtx/frontend/tracer/in_order.h"
#include "grtx/frontend/tracer/ray_tracer.h"
#include "grtx/frontend/tracer/secondary_plan.h"

namespace grtx::frontend {
namespace {

/// State of one thread, created on its first group.
struct Worker {
  Worker(const TracedStructure& structure, const TracerOptions& options, Footprint* footprint,
         const traces::Header* header)
      : tracer(structure, options), secondary_tracer(structure, options), recorder(structure.image, header) {
    if (header != nullptr && EncodingRecorder::can_record(*header)) encoding_recorder.emplace(structure.image, *header);
    if (footprint != nullptr) {
      tracker.emplace(*footprint);
      tracer.track_visits(&*tracker);
      secondary_tracer.track_visits(&*tracker);
    }
  }
  RayTracer tracer;
  RayTracer secondary_tracer;  ///< for separate counts
  std::uint64_t secondary_unique = 0;
  GroupRecorder recorder;
  std::optional<EncodingRecorder> encoding_recorder;  ///< used instead where it can record
  std::optional<VisitTracker> tracker;
};

/// Traces a group's rays and passes their trace to the writer, if there is one.
template <typename F>
void trace_group_of(Worker& worker, std::size_t index, traces::RayKind kind, traces::Writer* writer, F&& trace_rays) {
  if (writer == nullptr) {
    NullRecorder recorder;
    return trace_rays(recorder, [](std::uint32_t) {});
  }
  const auto write = [&](auto& recorder) {
    recorder.begin_group(static_cast<std::uint32_t>(index), kind);
    trace_rays(recorder, [&](std::uint32_t pixel) { recorder.begin_ray(pixel); });
    writer->append(recorder.end_group());
  };
  if (worker.encoding_recorder) {
    write(*worker.encoding_recorder);
  } else {
    write(worker.recorder);
  }
}

PixelCost cost_so_far(const TracerCounters& c) {
  return {static_cast<std::uint32_t>(c.visits()), static_cast<std::uint32_t>(c.rounds),
          static_cast<std::uint32_t>(c.blended), static_cast<std::uint32_t>(c.checkpoints_written)};
}

/// Calls trace() and adds to *cost (if not null) what the tracer counted in it. Differences of 32-bit counts are right
/// even after the sums have wrapped around.
template <typename F>
void measure(const RayTracer& tracer, PixelCost* cost, F&& trace) {
  if (cost == nullptr) return trace();
  const PixelCost before = cost_so_far(tracer.counters());
  trace();
  const PixelCost after = cost_so_far(tracer.counters());
  *cost += {after.visits - before.visits, after.rounds - before.rounds, after.blended - before.blended,
            after.checkpoints - before.checkpoints};
}

/// The header's fields for structure, camera and options. Structure: AccelerationStructure or MultiObjectWorld.
template <typename Structure>
traces::Header header_of(const Structure& accel, const Camera& camera, const TracerOptions& options,
                         const RenderOptions& render) {
  traces::Header header;
  header.accel = accel.options().kind;
  header.tracing = options.tracing;
  header.k = options.k;
  header.checkpoint = options.checkpoint;
  header.checkpoint_order = options.checkpoint_order;
  header.checkpoint_bins = options.checkpoint ? options.checkpoint_bins : 0;
  header.child_order = options.child_order;
  header.pop_test = options.pop_test;
  header.any_hit = options.any_hit;
  header.ert_check = options.ert_check;
  header.ahead = options.ahead;
  header.opacity_bound = options.opacity_bound;
  header.colour = options.colour;
  header.width = camera.width;
  header.height = camera.height;
  header.warp_size = render.warp_size;
  // The tile of the usual warp; a smaller warp takes the part of it that map_pixels() gives.
  header.warp_mapping = render.linear_mapping ? traces::WarpMapping::linear : traces::WarpMapping::tile8x4;
  header.groups = map_pixels(camera.width, camera.height, render.linear_mapping, render.warp_size).size();
  if (render.secondary != nullptr) header.groups += render.secondary->groups.size();
  header.layout = accel.options().layout;
  header.bvh_width = accel.options().width;
  header.node_image_bytes = accel.image().size();
  if constexpr (requires { accel.counts(); }) header.wide_leaves = accel.counts().wide;
  header.root = accel.root();
  header.two_level = is_two_level(header.accel);
  header.blas_base = accel.blas_header();
  header.blas_root = accel.blas_root();
  header.blas_bytes = header.two_level ? header.node_image_bytes - header.blas_base : 0;
  header.checkpoint_capacity = options.checkpoint ? options.checkpoint_capacity : 0;
  header.inputs["camera"] = camera.name;
  header.inputs["camera_hash"] = hex(camera.hash());
  header.inputs["fov_scale"] = fmt::format("{}", camera.fov_scale);
  return header;
}

/// Notes in the header what reading clamped in more than one in a hundred of a file's rows: then the scene is another.
void note_clamped(const LoadReport& report, traces::Header& header) {
  for (const auto& [reason, rows] : report.clamped) {
    if (100 * rows <= report.rows) continue;
    std::string& clamped = header.inputs["clamped"];
    if (!clamped.empty()) clamped += "; ";
    clamped += std::to_string(rows) + " of " + std::to_string(report.rows) + " rows: " + reason;
  }
}

/// One call of render().
class ViewRender {
 public:
  ViewRender(const TracedStructure& structure, const Camera& camera, const TracerOptions& options,
             const RenderOptions& render, traces::Writer* writer)
      : camera_(camera),
        render_(render),
        writer_(writer),
        plan_(render.secondary != nullptr && !render.secondary->rays.empty() ? render.secondary : nullptr),
        origin_(camera.position - structure.offset),
        groups_(map_pixels(camera.width, camera.height, render.linear_mapping, render.warp_size)),
        workers_([this, &structure, &options] {
          return Worker(structure, options, footprint_ ? &*footprint_ : nullptr,
                        writer_ != nullptr ? &writer_->header() : nullptr);
        }),
        secondary_colours_(plan_ != nullptr ? plan_->rays.size() : 0),
        secondary_costs_(render.pixel_costs ? secondary_colours_.size() : 0),
        secondary_sequences_(render.keep_sequences ? secondary_colours_.size() : 0),
        progress_(std::string(render.doing) + " " + accel_name(structure.options.kind),
                  std::size_t{camera.width} * camera.height + secondary_colours_.size(), " rays", render.quiet) {
    result_.image = Image(camera.width, camera.height);
    if (render.keep_sequences) result_.sequences.resize(result_.image.pixels.size());
    if (render.pixel_costs) result_.pixel_costs.resize(result_.image.pixels.size());
    if (render.count_unique) footprint_.emplace(structure.image);
  }

  RenderResult run() {
    const auto start = std::chrono::steady_clock::now();
    // In order: the writer lets no group run far ahead of one that is missing.
    for_each_in_order(groups_.size() + (plan_ != nullptr ? plan_->groups.size() : 0), render_.threads,
                      [this](std::size_t i) {
                        if (i < groups_.size()) {
                          trace_group(i);
                        } else {
                          trace_secondary_group(i - groups_.size());
                        }
                      });
    result_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    progress_.finish();
    add_secondary_rays();
    add_counters();
    return std::move(result_);
  }

 private:
  void trace_group(std::size_t index) {
    Worker& worker = workers_.local();
    const auto& pixels = groups_[index];
    const auto trace_rays = [&](auto& recorder, auto&& begin) {
      for (std::size_t lane = 0; lane < pixels.size(); ++lane) {
        const std::uint32_t pixel = pixels[lane];
        begin(pixel);
        const glm::dvec3 direction = camera_.direction(pixel % camera_.width, pixel / camera_.width);
        if (direction == glm::dvec3(0.0)) continue;  // the projection has no ray here
        if (render_.keep_sequences) worker.tracer.collect_blended(&result_.sequences[pixel]);
        const float limit = render_.secondary != nullptr
                                ? render_.secondary->primary_limit(origin_, glm::vec3(direction))
                                : std::numeric_limits<float>::infinity();
        measure(worker.tracer, render_.pixel_costs ? &result_.pixel_costs[pixel] : nullptr, [&] {
          result_.image.pixels[pixel] =
              worker.tracer.trace(TraceRay(origin_, glm::vec3(direction)), recorder, 1.0f, limit).colour;
        });
      }
    };
    trace_group_of(worker, render_.first_group + index, traces::RayKind::primary, writer_, trace_rays);
    progress_.add(pixels.size());
  }

  void trace_secondary_group(std::size_t index) {
    Worker& worker = workers_.local();
    const SecondaryGroup& group = plan_->groups[index];
    const std::uint64_t unique = worker.tracker ? worker.tracker->unique() : 0;
    const auto trace_rays = [&](auto& recorder, auto&& begin) {
      for (std::uint32_t lane = 0; lane < group.count; ++lane) {
        const std::size_t number = group.first + lane;
        const SecondaryRay& ray = plan_->rays[number];
        begin(ray.pixel);
        if (render_.keep_sequences) worker.secondary_tracer.collect_blended(&secondary_sequences_[number]);
        measure(worker.secondary_tracer, render_.pixel_costs ? &secondary_costs_[number] : nullptr, [&] {
          secondary_colours_[number] =
              worker.secondary_tracer.trace(TraceRay(ray.origin, ray.direction), recorder, ray.transmittance, ray.limit)
                  .colour;
        });
      }
    };
    trace_group_of(worker, render_.first_group + groups_.size() + index, group.kind, writer_, trace_rays);
    if (worker.tracker) worker.secondary_unique += worker.tracker->unique() - unique;
    progress_.add(group.count);
  }

  /// Rays of one pixel add up in the order of their path, whichever thread traced them.
  void add_secondary_rays() {
    for (std::size_t i = 0; i < secondary_colours_.size(); ++i) {
      const std::uint32_t pixel = plan_->rays[i].pixel;
      result_.image.pixels[pixel] += secondary_colours_[i];
      if (render_.pixel_costs) result_.pixel_costs[pixel] += secondary_costs_[i];
      if (render_.keep_sequences) {
        auto& sequence = result_.sequences[pixel];
        sequence.insert(sequence.end(), secondary_sequences_[i].begin(), secondary_sequences_[i].end());
      }
    }
  }

  void add_counters() {
    for (const Worker& worker : workers_) {
      result_.secondary.add(worker.secondary_tracer.counters());
      result_.secondary.visits_unique += worker.secondary_unique;
      result_.counters.add(worker.tracer.counters());
      result_.counters.add(worker.secondary_tracer.counters());
      if (worker.tracker) result_.counters.visits_unique += worker.tracker->unique();
    }
    if (footprint_) result_.footprint_bytes = footprint_->bytes();
  }

  const Camera& camera_;
  const RenderOptions& render_;
  traces::Writer* writer_;
  const SecondaryPlan* plan_;  ///< null: no secondary rays
  glm::vec3 origin_;
  std::vector<std::vector<std::uint32_t>> groups_;  ///< pixels of each group
  std::optional<Footprint> footprint_;
  tbb::enumerable_thread_specific<Worker> workers_;
  RenderResult result_;
  std::vector<glm::vec3> secondary_colours_;
  std::vector<PixelCost> secondary_costs_;
  std::vector<std::vector<std::uint32_t>> secondary_sequences_;
  Progress progress_;
};

}  // namespace

std::vector<std::vector<std::uint32_t>> map_pixels(unsigned width, unsigned height, bool linear, unsigned warp_size) {
  if (warp_size != 4 && warp_size != 8 && warp_size != 16 && warp_size != 32) {
    throw Error("warp size", std::to_string(warp_size), "must be 4, 8, 16 or 32");
  }
  std::vector<std::vector<std::uint32_t>> groups;
  if (linear) {
    const std::uint32_t pixels = width * height;
    for (std::uint32_t first = 0; first < pixels; first += warp_size) {
      auto& group = groups.emplace_back();
      for (std::uint32_t p = first; p < std::min(pixels, first + warp_size); ++p) group.push_back(p);
    }
    return groups;
  }
  const unsigned tile_width = warp_size == 32 ? 8 : warp_size == 4 ? 2 : 4;
  const unsigned tile_height = warp_size / tile_width;
  for (unsigned y = 0; y < height; y += tile_height) {
    for (unsigned x = 0; x < width; x += tile_width) {
      auto& group = groups.emplace_back();
      for (unsigned j = y; j < std::min(height, y + tile_height); ++j) {
        for (unsigned i = x; i < std::min(width, x + tile_width); ++i) group.push_back(j * width + i);
      }
    }
  }
  return groups;
}

traces::Header trace_header(const Scene& scene, const Camera& camera, const AccelerationStructure& accel,
                            const TracerOptions& options, const RenderOptions& render) {
  traces::Header header = header_of(accel, camera, options, render);
  header.gaussians = scene.size();
  header.sh_degree = scene.sh_degree;
  header.sh_record_bytes = traces::sh_record_bytes(header.layout, header.sh_degree);
  header.inputs["scene"] = scene.name;
  header.inputs["scene_hash"] = scene.hash;
  note_clamped(scene.report, header);
  return header;
}

traces::Header trace_header(const MultiObjectWorld& world, const Camera& camera, const TracerOptions& options,
                            const RenderOptions& render) {
  traces::Header header = header_of(world, camera, options, render);
  header.gaussians = world.records();
  header.sh_degree = world.sh_degree();
  header.sh_record_bytes = traces::sh_record_bytes(header.layout, header.sh_degree);
  header.scene_leaves = world.scene_leaves();
  for (const auto& object : world.objects()) {
    header.inputs["object_hash." + std::to_string(header.object_roots.size())] = object->scene.hash;
    header.object_roots.push_back(object->root);
    note_clamped(object->scene.report, header);
  }
  return header;
}

RenderResult render(const Scene& scene, const PreparedGaussians& gaussians, const AccelerationStructure& accel,
                    const Camera& camera, const TracerOptions& options, const RenderOptions& render,
                    traces::Writer* writer) {
  return frontend::render(TracedStructure(scene, gaussians, accel), camera, options, render, writer);
}

RenderResult render(const TracedStructure& structure, const Camera& camera, const TracerOptions& options,
                    const RenderOptions& render, traces::Writer* writer) {
  if (writer != nullptr && !options.walk_blas) throw std::logic_error("a trace holds the hardware's visits");
  RenderResult result = ViewRender(structure, camera, options, render, writer).run();
  if (render.count_hits) result.counters.hits = count_hits(structure, camera, options, render);
  return result;
}

std::uint64_t count_hits(const TracedStructure& structure, const Camera& camera, const TracerOptions& options,
                         const RenderOptions& render) {
  TracerOptions all = options;
  all.ert = 0.0f;
  all.ert_check = ErtCheck::hit;
  all.any_hit = AnyHit::immediate;
  all.ahead = 1;
  all.opacity_bound = OpacityBound::off;
  all.tracing = Tracing::single;  // one round collects up to k hits
  all.k = kMaxK;
  all.checkpoint = false;
  all.resume = Resume::exact;
  all.walk_blas = false;
  RenderOptions rays;
  rays.threads = render.threads;
  rays.linear_mapping = render.linear_mapping;
  rays.warp_size = render.warp_size;
  rays.quiet = render.quiet;
  rays.doing = "counting hits in";
  rays.secondary = render.secondary;
  return frontend::render(structure, camera, all, rays, nullptr).counters.processed;
}

}  // namespace grtx::frontend
