// SPDX-License-Identifier: Apache-2.0
// Render time against error, over acceleration structure, k, checkpointing, termination threshold, kernel radius,
// precision of the stored boxes and precision of the response. Prints the Pareto front, writes NAME.csv.
//
//   build/bench/bench/error_vs_time SCENE CAMERAS.json -o FOLDER [--view I --width W --height H --full]
//
// Error: PSNR and largest channel error against the fp64 reference of the same proxy that never terminates early, with
// the adaptive radius. Time: processor time of one thread over that of tri20 with the defaults, in interleaved runs.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <tuple>

#include "bench/processor_time.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/frontend/reference/reference.h"
#include "grtx/frontend/scene/scene_io.h"
#include "grtx/frontend/tracer/tracer.h"

namespace grtx::bench {
namespace {

using namespace grtx::frontend;

struct Options {
  std::string scene, cameras, output;
  unsigned view = 0, width = 64, height = 64, runs = 3;
  bool full = false;
};

struct Setting {
  AccelKind accel = AccelKind::tri20;
  unsigned k = 8;
  bool checkpoint = false;
  float ert = 0.001f;
  bool adaptive = true;
  unsigned box_bits = 8;
  ResponsePrecision response = ResponsePrecision::fp32;

  std::string name() const {
    return fmt::format("{} k={} {} ert={:g} {} {}-bit {}", accel_name(accel), k, checkpoint ? "ckpt" : "restart",
                       static_cast<double>(ert), adaptive ? "adaptive" : "3sigma", box_bits, name_of(response));
  }
  /// Factors that are not at their defaults, besides structure and checkpointing.
  int changed() const {
    return (k != 8) + (ert != 0.001f) + !adaptive + (box_bits != 8) + (response != ResponsePrecision::fp32);
  }
};

struct Measured {
  Setting setting;
  double seconds = 0.0;  ///< least of the runs
  Comparison error;
  std::uint64_t visits = 0;
  bool front = false;
};

// Every factor on its own from the defaults, for each structure with and without checkpointing; or all combinations.
std::vector<Setting> settings(bool full) {
  const std::vector<unsigned> ks = {4, 8, 16, 64};
  const std::vector<float> erts = {0.001f, 0.0f, 0.01f, 0.03f};
  const std::vector<unsigned> bits = {8, 6, 4};
  const std::vector<ResponsePrecision> responses = {ResponsePrecision::fp32, ResponsePrecision::fp16,
                                                    ResponsePrecision::bf16};
  std::vector<Setting> all;
  for (std::size_t a = 0; a < names_of<AccelKind>().size(); ++a) {
    for (const bool checkpoint : {false, true}) {
      for (const unsigned k : ks) {
        for (const float ert : erts) {
          for (const bool adaptive : {true, false}) {
            for (const unsigned b : bits) {
              for (const ResponsePrecision r : responses) {
                const Setting s{static_cast<AccelKind>(a), k, checkpoint, ert, adaptive, b, r};
                if (full || s.changed() <= 1) all.push_back(s);
              }
            }
          }
        }
      }
    }
  }
  return all;
}

ReferenceProxy reference_proxy(AccelKind kind) {
  switch (proxy_of(kind)) {
    case ProxyKind::icosahedron20:
      return ReferenceProxy::icosahedron20;
    case ProxyKind::icosphere80:
      return ReferenceProxy::icosphere80;
    default:
      return ReferenceProxy::sphere;
  }
}

// Beyond this all settings are equally exact.
double capped(double psnr) { return std::min(psnr, 160.0); }

void mark_front(std::vector<Measured>& all) {
  for (Measured& m : all) {
    m.front = std::none_of(all.begin(), all.end(), [&](const Measured& o) {
      const bool no_worse = o.seconds <= m.seconds && capped(o.error.psnr) >= capped(m.error.psnr);
      return no_worse && (o.seconds < m.seconds || capped(o.error.psnr) > capped(m.error.psnr));
    });
  }
}

void run(const Options& options) {
  const Scene scene = load_scene(options.scene);
  const std::vector<Camera> cameras = load_cameras(options.cameras);
  if (options.view >= cameras.size()) throw Error(options.cameras, "", fmt::format("has no view {}", options.view));
  const Camera camera = cameras[options.view].resized(options.width, options.height);

  std::map<ReferenceProxy, Image> truth;
  for (const ReferenceProxy proxy :
       {ReferenceProxy::icosahedron20, ReferenceProxy::icosphere80, ReferenceProxy::sphere}) {
    ReferenceOptions reference;
    reference.proxy = proxy;
    reference.ert = 0.0;
    truth[proxy] = render_reference(scene, camera, reference).image;
  }
  std::vector<Measured> all;
  const PreparedGaussians adaptive(scene, true), three_sigma(scene, false);
  std::vector<Setting> list = settings(options.full);
  std::stable_sort(list.begin(), list.end(), [](const Setting& a, const Setting& b) {
    return std::tie(a.accel, a.adaptive, a.box_bits) < std::tie(b.accel, b.adaptive, b.box_bits);
  });
  // A reference setting runs beside each group, so that every time is a ratio of neighbours.
  const AccelerationStructure base_accel(adaptive, AccelOptions{});
  RenderOptions one_thread;
  one_thread.threads = 1;
  const auto timed = [&](const PreparedGaussians& g, const AccelerationStructure& accel, const TracerOptions& tracer) {
    const double start = cpu_seconds();
    RenderResult result = render(scene, g, accel, camera, tracer, one_thread, nullptr);
    return std::pair(cpu_seconds() - start, std::move(result));
  };
  for (std::size_t i = 0; i < list.size();) {
    const Setting& first = list[i];
    const PreparedGaussians& gaussians = first.adaptive ? adaptive : three_sigma;
    AccelOptions accel_options;
    accel_options.kind = first.accel;
    accel_options.box_bits = first.box_bits;
    const AccelerationStructure accel(gaussians, accel_options);
    std::size_t end = i;
    while (end < list.size() && list[end].accel == first.accel && list[end].adaptive == first.adaptive &&
           list[end].box_bits == first.box_bits) {
      ++end;
    }
    double base_seconds = 1e300;
    const std::size_t begin_measured = all.size();
    for (unsigned r = 0; r < options.runs; ++r) {
      base_seconds = std::min(base_seconds, timed(adaptive, base_accel, TracerOptions{}).first);
      for (std::size_t j = i; j < end; ++j) {
        TracerOptions tracer;
        tracer.k = list[j].k;
        tracer.checkpoint = list[j].checkpoint;
        tracer.ert = list[j].ert;
        tracer.kernel = {list[j].adaptive};
        tracer.response_precision = list[j].response;
        auto [seconds, result] = timed(gaussians, accel, tracer);
        if (r == 0) {
          Measured& m = all.emplace_back();
          m.setting = list[j];
          m.seconds = seconds;
          m.error = compare(truth.at(reference_proxy(first.accel)), result.image);
          m.visits = result.counters.visits();
        } else {
          Measured& m = all[begin_measured + (j - i)];
          m.seconds = std::min(m.seconds, seconds);
        }
      }
    }
    for (std::size_t j = begin_measured; j < all.size(); ++j) all[j].seconds /= base_seconds;
    i = end;
  }
  mark_front(all);

  const std::string name = std::filesystem::path(options.scene).stem().string();
  std::filesystem::create_directories(options.output);
  std::string csv =
      "accel,k,checkpoint,ert,kernel_radius,box_bits,response,relative_time,psnr_db,max_error,visits,front\n";
  for (const Measured& m : all) {
    const Setting& s = m.setting;
    csv += fmt::format("{},{},{},{:g},{},{},{},{:.4f},{:.2f},{:.3g},{},{}\n", accel_name(s.accel), s.k,
                       s.checkpoint ? "on" : "off", static_cast<double>(s.ert), s.adaptive ? "adaptive" : "3sigma",
                       s.box_bits, name_of(s.response), m.seconds, m.error.psnr, m.error.max_error, m.visits,
                       m.front ? 1 : 0);
  }
  write_file(options.output + "/" + name + ".csv", csv);
  fmt::print("\n{}: {} Gaussians, {}x{}, {} settings; the Pareto front:\n\n", name, scene.size(), camera.width,
             camera.height, all.size());
  fmt::print("| setting | time | PSNR, dB | largest error |\n|---|---|---|---|\n");
  std::sort(all.begin(), all.end(), [](const Measured& a, const Measured& b) { return a.seconds < b.seconds; });
  for (const Measured& m : all) {
    if (!m.front) continue;
    fmt::print("| {} | {:.2f} | {:.1f} | {:.2g} |\n", m.setting.name(), m.seconds, m.error.psnr, m.error.max_error);
  }
  fmt::print(
      "\nEach factor alone, tlas-tri20 with checkpointing:\n\n| setting | time | PSNR, dB | visits "
      "|\n|---|---|---|---|\n");
  for (const Measured& m : all) {
    const Setting& s = m.setting;
    if (s.accel != AccelKind::tlas_tri20 || !s.checkpoint || s.changed() > 1) continue;
    fmt::print("| {} | {:.2f} | {:.1f} | {} |\n", s.name(), m.seconds, m.error.psnr, m.visits);
  }
}

}  // namespace
}  // namespace grtx::bench

int main(int argc, char** argv) {
  grtx::bench::Options options;
  CLI::App app("Render time against error");
  app.add_option("scene", options.scene, "Scene file")->required();
  app.add_option("cameras", options.cameras, "Cameras")->required();
  app.add_option("-o,--output", options.output, "Folder for the CSV")->required();
  app.add_option("--view", options.view, "Camera")->capture_default_str();
  app.add_option("--width", options.width, "Pixels")->capture_default_str();
  app.add_option("--height", options.height, "Pixels")->capture_default_str();
  app.add_option("--runs", options.runs, "Interleaved runs")->check(CLI::Range(1u, 1000u))->capture_default_str();
  app.add_flag("--full", options.full, "All combinations instead of one factor at a time");
  CLI11_PARSE(app, argc, argv);
  try {
    grtx::bench::run(options);
  } catch (const grtx::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
