// The tracer against what a user would write with Embree itself (bench/embree_peers.h), on the same rays, k and rules.
// One thread, processor time, interleaved runs; a time counts only when the images agree to 60 dB.
//
//   build/bench/bench/peers SCENE CAMERAS.json [SCENE CAMERAS.json ...] [--view I --sizes N,N,... --k K --runs N]
//                           [--only NAME,NAME,...]
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>

#include "bench/embree_peers.h"
#include "bench/processor_time.h"
#include "grtx/base/error.h"
#include "grtx/frontend/scene/scene_io.h"
#include "grtx/frontend/tiles/tile_tracer.h"
#include "grtx/frontend/tracer/tracer.h"

namespace grtx::bench {
namespace {

using namespace grtx::frontend;

constexpr double kRequiredPsnr = 60.0;

struct Options {
  std::vector<std::string> files;
  unsigned view = 0, k = 16, runs = 5;
  std::vector<unsigned> sizes{128};  ///< pixels an edge
  std::vector<std::string> only;     ///< contenders; empty: all
};

struct Contender {
  std::string name;
  bool ours = false;
  bool rounds = false;  ///< ours, as the hardware traces
  bool triangles = false;
  double build_seconds = 0.0;  ///< processor time of its structure
  std::function<Image(const Camera&)> render;
  std::vector<double> seconds;
  Image image;
  double median() const {
    std::vector<double> sorted = seconds;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    return sorted[sorted.size() / 2];
  }
};

/// One scene with everything that is built for it.
class Match {
 public:
  Match(const std::string& file, const std::string& cameras, const Options& options)
      : file_(file), options_(options), scene_(load_scene(file)), gaussians_(scene_, true) {
    const std::vector<Camera> all = load_cameras(cameras);
    if (options.view >= all.size()) throw Error(cameras, "", fmt::format("has no view {}", options.view));
    camera_ = all[options.view];
    for (const AccelKind kind :
         {AccelKind::tri20, AccelKind::ellipsoid, AccelKind::tlas_tri20, AccelKind::tlas_sphere}) {
      add_rounds(kind);
    }
    add_tiles(ProxyKind::sphere, "tiles");
    add_tiles(ProxyKind::icosahedron20, "tiles tri20");
    for (const auto& [peer, name] : peers()) add_peer(peer, name);
    for (const std::string& name : options.only) {
      if (std::none_of(contenders_.begin(), contenders_.end(), [&](const Contender& c) { return c.name == name; })) {
        throw Error("--only", name, "is no contender");
      }
    }
  }

  void measure(unsigned size) {
    const Camera camera = camera_.resized(size, size);
    for (Contender& c : contenders_) c.seconds.clear();
    for (unsigned run = 0; run < options_.runs; ++run) {
      for (Contender& c : contenders_) {
        const double start = cpu_seconds();
        c.image = c.render(camera);
        c.seconds.push_back(cpu_seconds() - start);
      }
    }
    print(camera);
  }

 private:
  bool wanted(const std::string& name) const {
    return options_.only.empty() || std::find(options_.only.begin(), options_.only.end(), name) != options_.only.end();
  }

  void add_rounds(AccelKind kind) {
    const AccelerationStructure* accel = nullptr;
    double build_seconds = 0.0;
    for (const bool checkpoint : {false, true}) {
      const std::string name = accel_name(kind) + (checkpoint ? " checkpoint" : "");
      if (!wanted(name)) continue;
      if (accel == nullptr) {
        const double start = cpu_seconds();
        accels_.push_back(std::make_unique<AccelerationStructure>(gaussians_, AccelOptions{kind, 6, false}));
        build_seconds = cpu_seconds() - start;
        accel = accels_.back().get();
      }
      TracerOptions tracer = tracer_options();
      tracer.checkpoint = checkpoint;
      Contender& c = contenders_.emplace_back();
      c.name = name;
      c.ours = true;
      c.rounds = true;
      c.triangles = proxy_of(kind) != ProxyKind::sphere;
      c.build_seconds = build_seconds;
      c.render = [this, accel, tracer](const Camera& camera) {
        return render(scene_, gaussians_, *accel, camera, tracer, one_thread(), nullptr).image;
      };
    }
  }

  void add_tiles(ProxyKind proxy, const std::string& name) {
    if (!wanted(name)) return;
    const double start = cpu_seconds();
    tiles_.push_back(std::make_unique<TileStructure>(scene_, gaussians_, proxy));
    Contender& c = contenders_.emplace_back();
    c.name = name;
    c.ours = true;
    c.triangles = proxy != ProxyKind::sphere;
    c.build_seconds = cpu_seconds() - start;
    c.render = [this, tiles = tiles_.back().get()](const Camera& camera) {
      return render_tiles(scene_, gaussians_, *tiles, camera, tracer_options(), one_thread()).image;
    };
  }

  void add_peer(Peer peer, const std::string& name) {
    if (!wanted(name)) return;
    const double start = cpu_seconds();
    embree_.push_back(std::make_unique<EmbreePeer>(peer, scene_, gaussians_));
    Contender& c = contenders_.emplace_back();
    c.name = name;
    c.triangles = has_triangles(peer);
    c.build_seconds = cpu_seconds() - start;
    c.render = [this, e = embree_.back().get()](const Camera& camera) { return e->render(camera, options_.k, 0.001f); };
  }

  TracerOptions tracer_options() const {
    TracerOptions tracer;
    tracer.k = options_.k;
    tracer.checkpoint_capacity = 65535;
    tracer.tmax_update = TmaxUpdate::kth;
    tracer.replay_tmax = ReplayTmax::kth;
    return tracer;
  }
  static RenderOptions one_thread() {
    RenderOptions options;
    options.threads = 1;
    return options;
  }

  double psnr_of(const Contender& c) const {
    for (const Contender& o : contenders_) {
      if (o.ours && o.triangles == c.triangles) return compare(o.image, c.image).psnr;
    }
    return 0.0;
  }
  /// The fastest of those whose image counts; null when there is none.
  template <typename F>
  const Contender* fastest(F&& is_asked_for) const {
    const Contender* best = nullptr;
    for (const Contender& c : contenders_) {
      if (!is_asked_for(c) || !(psnr_of(c) >= kRequiredPsnr)) continue;
      if (best == nullptr || c.median() < best->median()) best = &c;
    }
    return best;
  }

  void print(const Camera& camera) const {
    const Contender* const exact = fastest([](const Contender& c) { return c.ours; });
    const Contender* const rounds = fastest([](const Contender& c) { return c.rounds; });
    const Contender* const peer = fastest([](const Contender& c) { return !c.ours; });
    const Contender* const unit = peer != nullptr ? peer : exact;
    if (unit == nullptr) throw Error(file_, "", "no contender's image counts");
    fmt::print("\n{}: {} Gaussians, {}x{}, k = {}, one thread\n\n", std::filesystem::path(file_).stem().string(),
               scene_.size(), camera.width, camera.height, options_.k);
    fmt::print("| tracer | PSNR to ours, dB | time / {} | build, s |\n|---|---|---|---|\n", unit->name);
    for (const Contender& c : contenders_) {
      const double psnr = psnr_of(c);
      const std::string ratio =
          psnr >= kRequiredPsnr ? fmt::format("{:.2f}", c.median() / unit->median()) : std::string("(image differs)");
      fmt::print("| {}{} | {} | {} | {:.2f} |\n", c.ours ? "" : "Embree ", c.name,
                 std::isinf(psnr) ? std::string("identical") : fmt::format("{:.1f}", psnr), ratio, c.build_seconds);
    }
    if (peer != nullptr) {
      fmt::print("\nfastest Embree variant ({})", peer->name);
      if (exact != nullptr) {
        fmt::print(" / our fastest exact mode ({}): {:.2f};", exact->name, peer->median() / exact->median());
      }
      if (rounds != nullptr) {
        fmt::print(" / our fastest in rounds ({}): {:.2f};", rounds->name, peer->median() / rounds->median());
      }
      fmt::print(" {:.2f} us a ray\n",
                 1e6 * peer->median() / (static_cast<double>(camera.width) * static_cast<double>(camera.height)));
    }
    std::fflush(stdout);
  }

  std::string file_;
  const Options& options_;
  Scene scene_;
  PreparedGaussians gaussians_;
  Camera camera_;
  std::vector<std::unique_ptr<AccelerationStructure>> accels_;
  std::vector<std::unique_ptr<TileStructure>> tiles_;
  std::vector<std::unique_ptr<EmbreePeer>> embree_;
  std::vector<Contender> contenders_;
};

}  // namespace
}  // namespace grtx::bench

int main(int argc, char** argv) {
  grtx::bench::Options options;
  CLI::App app("The tracer against Embree");
  app.add_option("files", options.files, "SCENE CAMERAS.json pairs")->required();
  app.add_option("--view", options.view, "Camera")->capture_default_str();
  app.add_option("--sizes", options.sizes, "Pixels of an edge, one image each")
      ->delimiter(',')
      ->check(CLI::Range(1u, 16384u))
      ->capture_default_str();
  app.add_option("--only", options.only, "Contenders that run (default: all)")->delimiter(',');
  app.add_option("--k", options.k, "k-buffer entries, at most 64")
      ->check(CLI::Range(1u, grtx::bench::kMostEntries))
      ->capture_default_str();
  app.add_option("--runs", options.runs, "Interleaved runs")->check(CLI::Range(1u, 1000u))->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    if (options.files.size() % 2 != 0) throw grtx::Error("command line", "", "each scene needs its cameras");
    for (std::size_t i = 0; i < options.files.size(); i += 2) {
      grtx::bench::Match match(options.files[i], options.files[i + 1], options);
      for (const unsigned size : options.sizes) match.measure(size);
    }
  } catch (const grtx::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
