// The tracer against what a user would write with Embree itself (bench/embree_peers.h), on the same rays, k and rules.
// One thread, processor time, interleaved runs; a time counts only when the images agree to 60 dB.
//
//   build/bench/bench/peers SCENE CAMERAS.json [SCENE CAMERAS.json ...] [--view I --width W --height H --k K --runs N]
#include <fmt/format.h>
#include <time.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>

#include "base/error.h"
#include "bench/embree_peers.h"
#include "frontend/scene_io.h"
#include "frontend/tracer.h"

namespace grtx::bench {
namespace {

using namespace grtx::frontend;

constexpr double kRequiredPsnr = 60.0;

double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Options {
  std::vector<std::string> files;
  unsigned view = 0, width = 128, height = 128, k = 16, runs = 5;
};

struct Contender {
  std::string name;
  bool ours = false;
  bool faithful = false;  ///< visits what the hardware visits
  bool triangles = false;
  std::function<Image()> render;
  std::vector<double> seconds;
  Image image;
  double median() const {
    std::vector<double> sorted = seconds;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    return sorted[sorted.size() / 2];
  }
};

void measure(const std::string& file, const std::string& cameras, const Options& options) {
  const Scene scene = load_scene(file);
  const std::vector<Camera> all = load_cameras(cameras);
  if (options.view >= all.size()) throw Error(cameras, "", fmt::format("has no view {}", options.view));
  const Camera camera = all[options.view].resized(options.width, options.height);
  const PreparedGaussians gaussians(scene, true);

  std::vector<std::unique_ptr<AccelerationStructure>> accels;
  std::vector<std::unique_ptr<EmbreePeer>> embree;
  std::vector<Contender> contenders;
  for (const AccelKind kind : {AccelKind::tri20, AccelKind::ellipsoid, AccelKind::tlas_tri20, AccelKind::tlas_sphere}) {
    accels.push_back(std::make_unique<AccelerationStructure>(gaussians, AccelOptions{kind, 6, false}));
    const AccelerationStructure* accel = accels.back().get();
    for (const bool checkpoint : {false, true}) {
      for (const bool faithful : {true, false}) {
        TracerOptions tracer;
        tracer.k = options.k;
        tracer.checkpoint = checkpoint;
        tracer.tmax_update = TmaxUpdate::kth;
        tracer.replay_tmax = ReplayTmax::kth;
        tracer.checkpoint_capacity = 65535;
        tracer.skips = faithful ? kFaithfulSkips : kAllSkips;
        RenderOptions render_options;
        render_options.threads = 1;
        Contender& c = contenders.emplace_back();
        c.name = accel_name(kind) + (checkpoint ? " checkpoint" : "") + (faithful ? "" : " skip-all");
        c.ours = true;
        c.faithful = faithful;
        c.triangles = proxy_of(kind) != ProxyKind::sphere;
        c.render = [&scene, &gaussians, &camera, accel, tracer, render_options] {
          return render(scene, gaussians, *accel, camera, tracer, render_options, nullptr).image;
        };
      }
    }
  }
  for (const auto& [peer, name] : peers()) {
    embree.push_back(std::make_unique<EmbreePeer>(peer, scene, gaussians));
    Contender& c = contenders.emplace_back();
    c.name = name;
    c.triangles = has_triangles(peer);
    c.render = [e = embree.back().get(), &camera, &options] { return e->render(camera, options.k, 0.001f); };
  }
  for (unsigned run = 0; run < options.runs; ++run) {
    for (Contender& c : contenders) {
      const double start = processor_seconds();
      c.image = c.render();
      c.seconds.push_back(processor_seconds() - start);
    }
  }
  const auto psnr_of = [&](const Contender& c) {
    for (const Contender& o : contenders) {
      if (o.ours && o.triangles == c.triangles) return compare(o.image, c.image).psnr;
    }
    return 0.0;
  };
  // Of those whose image counts.
  const auto fastest = [&](auto&& wanted) {
    const Contender* best = nullptr;
    for (const Contender& c : contenders) {
      if (!wanted(c) || !(psnr_of(c) >= kRequiredPsnr)) continue;
      if (best == nullptr || c.median() < best->median()) best = &c;
    }
    if (best == nullptr) throw Error(file, "", "no contender's image counts");
    return best;
  };
  const Contender* const exact = fastest([](const Contender& c) { return c.ours; });
  const Contender* const faithful = fastest([](const Contender& c) { return c.faithful; });
  const Contender* const peer = fastest([](const Contender& c) { return !c.ours; });
  fmt::print("\n{}: {} Gaussians, {}x{}, k = {}, one thread\n\n", std::filesystem::path(file).stem().string(),
             scene.size(), camera.width, camera.height, options.k);
  fmt::print("| tracer | PSNR to ours, dB | time / fastest Embree variant |\n|---|---|---|\n");
  for (const Contender& c : contenders) {
    const double psnr = psnr_of(c);
    const std::string ratio =
        psnr >= kRequiredPsnr ? fmt::format("{:.2f}", c.median() / peer->median()) : std::string("(image differs)");
    fmt::print("| {}{} | {} | {} |\n", c.ours ? "" : "Embree ", c.name,
               std::isinf(psnr) ? std::string("identical") : fmt::format("{:.1f}", psnr), ratio);
  }
  fmt::print(
      "\nfastest Embree variant ({}) / our fastest exact mode ({}): {:.2f}; / our fastest faithful mode ({}): {:.2f}\n",
      peer->name, exact->name, peer->median() / exact->median(), faithful->name, peer->median() / faithful->median());
  std::fflush(stdout);
}

}  // namespace
}  // namespace grtx::bench

int main(int argc, char** argv) {
  grtx::bench::Options options;
  CLI::App app("The tracer against Embree");
  app.add_option("files", options.files, "SCENE CAMERAS.json pairs")->required();
  app.add_option("--view", options.view, "Camera")->capture_default_str();
  app.add_option("--width", options.width, "Pixels")->capture_default_str();
  app.add_option("--height", options.height, "Pixels")->capture_default_str();
  app.add_option("--k", options.k, "k-buffer entries, at most 64")
      ->check(CLI::Range(1u, grtx::bench::kMostEntries))
      ->capture_default_str();
  app.add_option("--runs", options.runs, "Interleaved runs")->check(CLI::Range(1u, 1000u))->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    if (options.files.size() % 2 != 0) throw grtx::Error("command line", "", "each scene needs its cameras");
    for (std::size_t i = 0; i < options.files.size(); i += 2) {
      grtx::bench::measure(options.files[i], options.files[i + 1], options);
    }
  } catch (const grtx::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
