#include "grtx/apps/grtx/tracer_cli.h"

#include <fmt/format.h>

#include "grtx/apps/grtx/options.h"
#include "grtx/base/error.h"

namespace grtx::sim {

using namespace frontend;

void add_tracer_options(CLI::App* command, TracerCli& cli) {
  command->add_option("--k", cli.k, "k-buffer entries a ray")->check(CLI::Range(1U, kMaxK));
  command->add_option("--checkpoint-capacity", cli.checkpoint_capacity, "Entries of one checkpoint buffer of a ray")
      ->check(CLI::Range(1U, 65535U));
  command->add_option("--ert", cli.ert, "Transmittance below which a ray ends")->check(CLI::Range(0.0, 1.0));
  command->add_option("--sort-key", cli.sort_key, "Distance that orders a ray's hits")
      ->check(one_of({"entry", "peak"}));
  command->add_option("--resume", cli.resume, "How a round continues: (t, id) order, or the paper's t_min < t")
      ->check(one_of({"exact", "strict"}));
  command->add_option("--kernel-radius", cli.kernel_radius, "Where a Gaussian ends")
      ->check(one_of({"adaptive", "3sigma"}));
  command->add_option("--child-order", cli.child_order, "Order in which hit children are visited")
      ->check(one_of({"near_first", "slot"}));
  command->add_option("--tmax-update", cli.tmax_update, "t_max after an any-hit: the reported hit's t, or the k-th")
      ->check(one_of({"reported", "kth"}));
  command->add_option("--checkpoint-order", cli.checkpoint_order, "Order in which replay reads the source buffer")
      ->check(one_of({"fifo", "lifo", "nearest"}));
  command->add_option("--replay-tmax", cli.replay_tmax, "t_max at the start of a round with a preloaded k-buffer")
      ->check(one_of({"infinity", "kth"}));
  command->add_option("--inside", cli.inside, "Gaussians whose proxy holds the ray origin")
      ->check(one_of({"skip", "count"}));
  command->add_option("--sh-dir", cli.sh_dir, "Direction in which the spherical harmonics are evaluated")
      ->check(one_of({"ray", "centre"}));
  command->add_option("--instance-bounds", cli.instance_bounds, "World boxes of instances")
      ->check(one_of({"tight", "box_corners"}));
  command->add_option("--bvh-width", cli.bvh_width, "Children of an internal node")->check(CLI::Range(2U, 8U));
  command->add_option("--mapping", cli.mapping, "How pixels form warps; tiles of 16, 8, 4: 4x4, 4x2, 2x2")
      ->check(one_of({"tile8x4", "linear"}));
  command->add_option("--warp-size", cli.warp_size, "Rays of a warp")->check(one_of({"4", "8", "16", "32"}));
  add_secondary_options(command, cli.secondary);
  command
      ->add_option("--tracing", cli.tracing,
                   "Rounds of k hits, one round that sorts all (--k holds them), a hit each, or the same image without "
                   "rounds, by tiles of rays (trace --no-trace)")
      ->check(one_of({"multi", "single", "closest", "tiles"}));
  command
      ->add_option("--triangle-test", cli.triangle_test, "Hit test of triangles: canonical, or their stored vertices")
      ->check(one_of({"canonical", "world"}));
  command->add_option("--box-bits", cli.box_bits, "Bits used of a stored box coordinate (a node keeps its size)")
      ->check(CLI::Range(2U, 8U));
  command
      ->add_option("--response-precision", cli.response_precision,
                   "Format to which every step of a Gaussian's response is rounded")
      ->check(one_of({"fp32", "fp16", "bf16"}));
  command->add_option(
      "--skip", cli.skip,
      "Work left out that changes no bit of the image: none, faithful (keeps the hardware's visits), all, "
      "or names separated by commas (docs/model/skips.md)");
  command->add_option("--threads", cli.threads, "Threads; 0 takes all");
}

TracerOptions tracer_options(const TracerCli& cli, bool checkpoint, AccelKind accel) {
  if (cli.tracing == "tiles") {
    throw Error("--tracing", "tiles", "visits what it likes and renders only: it needs trace --no-trace");
  }
  TracerOptions o;
  o.k = cli.k;
  o.checkpoint = checkpoint;
  o.checkpoint_capacity = cli.checkpoint_capacity;
  o.ert = cli.ert;
  o.sort_key = cli.sort_key == "peak" ? SortKey::peak : SortKey::entry;
  o.resume = cli.resume == "strict" ? Resume::strict : Resume::exact;
  o.inside = cli.inside == "count" ? InsideRule::count : InsideRule::skip;
  o.tmax_update = cli.tmax_update == "kth" ? TmaxUpdate::kth : TmaxUpdate::reported;
  o.checkpoint_order = cli.checkpoint_order == "lifo"      ? CheckpointOrder::lifo
                       : cli.checkpoint_order == "nearest" ? CheckpointOrder::nearest
                                                           : CheckpointOrder::fifo;
  o.replay_tmax = cli.replay_tmax == "kth" ? ReplayTmax::kth : ReplayTmax::infinity;
  o.child_order = cli.child_order == "slot" ? ChildOrder::slot : ChildOrder::near_first;
  o.sh_direction = cli.sh_dir == "centre" ? ShDirection::centre : ShDirection::ray;
  o.adaptive_radius = cli.kernel_radius == "adaptive";
  o.tracing = cli.tracing == "single" ? Tracing::single : cli.tracing == "closest" ? Tracing::closest : Tracing::multi;
  o.triangle_test = cli.triangle_test == "world" ? TriangleTest::world : TriangleTest::canonical;
  o.response_precision = cli.response_precision == "fp16"   ? ResponsePrecision::fp16
                         : cli.response_precision == "bf16" ? ResponsePrecision::bf16
                                                            : ResponsePrecision::fp32;
  o.skips = skips_from_text(cli.skip);
  if (o.tracing == Tracing::closest) o.k = 1;
  if (checkpoint && o.tracing != Tracing::multi) {
    throw Error("--tracing", cli.tracing, "has no rounds to resume: checkpointing needs --tracing multi");
  }
  if (o.triangle_test == TriangleTest::world && proxy_of(accel) == ProxyKind::sphere) {
    throw Error("--triangle-test", "world", "needs a structure of triangles, not --accel " + accel_name(accel));
  }
  if (o.triangle_test == TriangleTest::world && o.sort_key == SortKey::peak) {
    throw Error("--triangle-test", "world", "measures where a triangle is entered: it needs --sort-key entry");
  }
  if (o.inside == InsideRule::count && proxy_of(accel) != ProxyKind::sphere) {
    throw Error("--inside", "count", "needs a sphere proxy: --accel ellipsoid or tlas-sphere");
  }
  return o;
}

AccelOptions accel_options(const TracerCli& cli, AccelKind accel) {
  return {accel, cli.bvh_width, cli.instance_bounds == "box_corners", cli.box_bits};
}

RenderOptions render_options(const TracerCli& cli, bool quiet) {
  RenderOptions r;
  r.threads = cli.threads;
  r.linear_mapping = cli.mapping == "linear";
  r.warp_size = cli.warp_size;
  r.quiet = quiet;
  return r;
}

std::map<std::string, std::string> option_inputs(const TracerCli& cli, bool checkpoint, AccelKind accel) {
  std::map<std::string, std::string> inputs = {{"accel", accel_name(accel)},
                                               {"k", std::to_string(cli.tracing == "closest" ? 1 : cli.k)},
                                               {"checkpoint", checkpoint ? "on" : "off"},
                                               {"checkpoint_capacity", std::to_string(cli.checkpoint_capacity)},
                                               {"ert", fmt::format("{}", cli.ert)},
                                               {"sort_key", cli.sort_key},
                                               {"resume", cli.resume},
                                               {"kernel_radius", cli.kernel_radius},
                                               {"child_order", cli.child_order},
                                               {"tmax_update", cli.tmax_update},
                                               {"checkpoint_order", cli.checkpoint_order},
                                               {"replay_tmax", cli.replay_tmax},
                                               {"inside", cli.inside},
                                               {"sh_dir", cli.sh_dir},
                                               {"instance_bounds", cli.instance_bounds},
                                               {"bvh_width", std::to_string(cli.bvh_width)},
                                               {"mapping", cli.mapping},
                                               {"warp_size", std::to_string(cli.warp_size)},
                                               {"tracing", cli.tracing},
                                               {"triangle_test", cli.triangle_test},
                                               {"box_bits", std::to_string(cli.box_bits)},
                                               {"response_precision", cli.response_precision}};
  inputs.merge(secondary_inputs(cli.secondary));
  return inputs;
}

}  // namespace grtx::sim
