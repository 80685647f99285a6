// How fast the functional tracer is: node visits and rays a second of one thread's CPU time, with the hardware's
// visits, and what recording, writing and checking a trace cost beside it. Every figure is also given as a ratio to a
// fixed loop run in between, so that runs on busy or different machines compare. Rounds of all measurements alternate
// and the best of each counts: what disturbs a run only makes it slower.
//
//   bench/tracer_speed SCENE CAMERAS [SCENE CAMERAS ...] [--accel tri20,tlas-tri20] [--size 128] [--repeats 3]
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "bench/processor_time.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/scene/scene_io.h"
#include "grtx/frontend/tracer/encoding_recorder.h"
#include "grtx/frontend/tracer/ray_recorder.h"
#include "grtx/frontend/tracer/ray_tracer.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/frontend/tracer/view_tracer.h"
#include "grtx/traces/check.h"
#include "grtx/traces/reader.h"
#include "grtx/traces/writer.h"

namespace {

using namespace grtx;
using bench::cpu_seconds;

/// The yardstick: dependent multiplications and additions in fp32. Never change it: ratios would lose their meaning.
/// Returns seconds of CPU for 2^26 steps.
double reference_loop() {
  const double start = cpu_seconds(CLOCK_THREAD_CPUTIME_ID);
  float x = 1.0f;
  for (unsigned i = 0; i < (1u << 26); ++i) x = x * 0.999f + 0.25f;
  volatile float keep = x;
  static_cast<void>(keep);
  return cpu_seconds(CLOCK_THREAD_CPUTIME_ID) - start;
}

struct Options {
  std::vector<std::string> files;
  std::vector<std::string> accels = {"tri20", "tlas-tri20"};
  unsigned size = 128;
  unsigned view = 0;
  unsigned k = 8;
  unsigned repeats = 3;
  bool checkpoint = false;
  bool traces = false;
  bool kth = false;
  std::string simd = frontend::simd_path_name(frontend::best_simd_path());
};

/// Best seconds of one kind of run.
struct Timed {
  std::string name;
  std::function<double()> run;  ///< returns seconds of CPU
  double best = 1e300;
};

frontend::SimdPath simd_path_from(const std::string& name) {
  for (const frontend::SimdPath path : frontend::available_simd_paths()) {
    if (frontend::simd_path_name(path) == name) return path;
  }
  throw Error("--simd", name, "the host has no such instructions");
}

void measure(const frontend::Scene& scene, const frontend::Camera& camera, frontend::AccelKind kind,
             const Options& options) {
  frontend::TracerOptions tracer_options;
  tracer_options.k = options.k;
  tracer_options.checkpoint = options.checkpoint;
  tracer_options.simd = simd_path_from(options.simd);
  if (options.kth) tracer_options.tmax_update = frontend::TmaxUpdate::kth;
  if (options.kth) tracer_options.replay_tmax = frontend::ReplayTmax::kth;
  const frontend::PreparedGaussians gaussians(scene, true);
  const frontend::AccelerationStructure accel(gaussians, {kind});
  const auto groups = frontend::map_pixels(camera.width, camera.height, false);
  const glm::vec3 origin(camera.position - scene.offset);
  frontend::TracerCounters counters;
  std::uint64_t colours = 0;

  const auto trace_groups = [&](auto& recorder, auto&& begin_group, auto&& end_group) {
    frontend::RayTracer tracer(scene, gaussians, accel, tracer_options);
    const double start = cpu_seconds(CLOCK_THREAD_CPUTIME_ID);
    std::vector<glm::vec3> image(static_cast<std::size_t>(camera.width) * camera.height);
    for (std::size_t g = 0; g < groups.size(); ++g) {
      begin_group(g);
      for (std::size_t lane = 0; lane < groups[g].size(); ++lane) {
        const std::uint32_t pixel = groups[g][lane];
        if constexpr (std::decay_t<decltype(recorder)>::kEnabled) recorder.begin_ray(pixel);
        const glm::vec3 direction(camera.direction(pixel % camera.width, pixel / camera.width));
        if (direction == glm::vec3(0.0f)) continue;
        image[pixel] = tracer.trace(frontend::TraceRay(origin, direction), recorder).colour;
      }
      end_group();
    }
    const double seconds = cpu_seconds(CLOCK_THREAD_CPUTIME_ID) - start;
    counters = tracer.counters();
    colours = xxh3(std::string_view(reinterpret_cast<const char*>(image.data()), image.size() * sizeof image[0]));
    return seconds;
  };

  std::vector<Timed> timed;
  timed.push_back({"loop", reference_loop});
  timed.push_back({"trace", [&] {
                     frontend::NullRecorder recorder;
                     return trace_groups(
                         recorder, [](std::size_t) {}, [] {});
                   }});
  const std::string path =
      (std::filesystem::temp_directory_path() / fmt::format("tracer_speed_{}.grtx", ::getpid())).string();
  std::uint64_t bytes = 0;
  if (options.traces) {
    timed.push_back(
        {"+ record", [&] {
           frontend::GroupRecorder recorder(accel.image());
           return trace_groups(
               recorder,
               [&](std::size_t g) { recorder.begin_group(static_cast<std::uint32_t>(g), traces::RayKind::primary); },
               [] {});
         }});
    timed.push_back(
        {"+ write", [&] {
           traces::Writer writer(path, trace_header(scene, camera, accel, tracer_options, {}));
           frontend::EncodingRecorder recorder(accel.image(), writer.header());
           const double seconds = trace_groups(
               recorder,
               [&](std::size_t g) { recorder.begin_group(static_cast<std::uint32_t>(g), traces::RayKind::primary); },
               [&] { writer.append(recorder.end_group()); });
           writer.finish();
           bytes = writer.bytes();
           return seconds;
         }});
    timed.push_back({"check", [&] {
                       const traces::Reader reader(path);
                       const double start = cpu_seconds(CLOCK_PROCESS_CPUTIME_ID);
                       traces::check(reader, true);
                       return cpu_seconds(CLOCK_PROCESS_CPUTIME_ID) - start;
                     }});
  }
  for (unsigned i = 0; i < options.repeats; ++i) {
    for (Timed& t : timed) t.best = std::min(t.best, t.run());
  }
  if (options.traces) std::filesystem::remove(path);

  const auto visits = static_cast<double>(counters.visits());
  const double trace = timed[1].best;
  fmt::print(
      "{:<28} {:<11} {:7.2f} M visits/s {:7.4f} M rays/s {:8.3f} M visits a loop  {:6.1f} visits a ray, "
      "{:.2f} rounds, {:.1f} blended; pixels {:016x}\n",
      scene.name, frontend::accel_name(kind), visits / trace * 1e-6, static_cast<double>(counters.rays) / trace * 1e-6,
      visits / trace * timed[0].best * 1e-6, visits / static_cast<double>(counters.rays),
      static_cast<double>(counters.rounds) / static_cast<double>(counters.rays),
      static_cast<double>(counters.blended) / static_cast<double>(counters.rays), colours);
  if (options.traces) {
    fmt::print(
        "{:<28} {:<11} record {:.2f} x, write {:.2f} x the time of tracing; check {:.1f} M visits/s; {:.3f} B a "
        "visit\n",
        "", "", timed[2].best / trace, timed[3].best / trace, visits / timed[4].best * 1e-6,
        static_cast<double>(bytes) / visits);
  }
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Measures the functional tracer");
  app.option_defaults()->always_capture_default();
  app.add_option("FILES", options.files, "Scene and camera files, in pairs")->required();
  app.add_option("--accel", options.accels, "Acceleration structures")->delimiter(',');
  app.add_option("--size", options.size, "Width and height of the view in pixels");
  app.add_option("--view", options.view, "Index of the view");
  app.add_option("--k", options.k, "k-buffer entries");
  app.add_option("--repeats", options.repeats, "Runs; the fastest of each kind counts")->check(CLI::PositiveNumber);
  app.add_flag("--checkpoint", options.checkpoint, "Checkpointing and replay");
  app.add_option("--simd", options.simd, "Vector instructions: portable, avx2 or avx512, as far as the host has them");
  app.add_flag("--kth", options.kth, "t_max is the k-th hit's t, also in replays");
  app.add_flag("--traces", options.traces, "Measure recording, writing and checking traces too");
  CLI11_PARSE(app, argc, argv);
  try {
    for (std::size_t i = 0; i + 1 < options.files.size(); i += 2) {
      const frontend::Scene scene = frontend::load_scene(options.files[i]);
      const frontend::Camera camera =
          frontend::load_cameras(options.files[i + 1]).at(options.view).resized(options.size, options.size);
      for (const std::string& name : options.accels) {
        measure(scene, camera, frontend::accel_from_name(name), options);
      }
    }
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "tracer_speed: {}\n", error.what());
    return 2;
  }
}
