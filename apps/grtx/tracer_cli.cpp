#include "grtx/apps/grtx/tracer_cli.h"

#include <fmt/format.h>

#include "grtx/apps/grtx/options.h"
#include "grtx/base/error.h"

namespace grtx::sim {

using namespace frontend;

namespace {

/// With the renderer that makes no trace.
std::vector<std::string> tracing_names() {
  std::vector<std::string> names = names_of<Tracing>();
  names.push_back("tiles");
  return names;
}

bool keeps_one_hit(Tracing tracing) { return tracing == Tracing::closest || tracing == Tracing::stochastic; }
bool keeps_one_hit(const std::string& tracing) {
  const auto known = from_name<Tracing>(tracing);
  return known && keeps_one_hit(*known);
}

unsigned bvh_width(const TracerCli& cli) { return cli.bvh_width.value_or(traces::default_width(cli.layout)); }

}  // namespace

void add_kernel_degree(CLI::App* command, unsigned& degree) {
  command
      ->add_option("--kernel-degree", degree,
                   "n of a Gaussian's response exp(-4.5 (d/3)^n), d in standard deviations: 2 is 3DGS, 4 what 3DGRT "
                   "trains by default")
      ->check(CLI::IsMember({2U, 4U}));
}

Kernel kernel_of(KernelRadius radius, unsigned degree) { return {radius == KernelRadius::adaptive, degree}; }

void add_tracer_options(CLI::App* command, TracerCli& cli) {
  command->add_option("--k", cli.k, "k-buffer entries a ray")->check(in_range(1U, kMaxK));
  command->add_option("--checkpoint-capacity", cli.checkpoint_capacity, "Entries of one checkpoint buffer of a ray")
      ->check(in_range(1U, 65535U));
  command->add_option("--ert", cli.ert, "Transmittance below which a ray ends")->check(in_range(0.0, 1.0));
  add_choice(command, "--sort-key", cli.sort_key, "Distance that orders a ray's hits");
  add_choice(command, "--resume", cli.resume, "How a round continues: (t, id) order, or the paper's t_min < t");
  add_choice(command, "--kernel-radius", cli.kernel_radius, "Where a Gaussian ends");
  add_kernel_degree(command, cli.kernel_degree);
  add_choice(command, "--child-order", cli.child_order,
             "Order in which hit children are visited; a machine may choose another");
  add_choice(
      command, "--pop-test", cli.pop_test,
      "Whether a node is compared with t_max when popped, for which its stack entry holds its t; a machine may choose "
      "another");
  add_choice(command, "--tmax-update", cli.tmax_update, "t_max after an any-hit: the reported hit's t, or the k-th");
  add_choice(command, "--checkpoint-order", cli.checkpoint_order, "Order in which replay reads the source buffer");
  add_choice(command, "--replay-tmax", cli.replay_tmax, "t_max at the start of a round with a preloaded k-buffer");
  add_choice(command, "--inside", cli.inside, "Gaussians whose proxy holds the ray origin");
  add_choice(command, "--sh-dir", cli.sh_dir, "Direction in which the spherical harmonics are evaluated");
  add_choice(command, "--instance-bounds", cli.instance_bounds, "World boxes of instances");
  add_choice(command, "--layout", cli.layout, "How nodes lie in memory (docs/model/node-image.md)");
  command->add_option("--bvh-width", cli.bvh_width, "Children of an internal node; with --layout compact 8 by default")
      ->check(in_range(2U, 8U))
      ->default_str("6");
  add_choice(command, "--mapping", cli.mapping, "How pixels form warps; tiles of 16, 8, 4: 4x4, 4x2, 2x2");
  command->add_option("--warp-size", cli.warp_size, "Rays of a warp")->check(one_of({"4", "8", "16", "32"}));
  add_secondary_options(command, cli.secondary);
  command
      ->add_option("--tracing", cli.tracing,
                   "Rounds of k hits, one round that sorts all (--k holds them), a hit each, the same image without "
                   "rounds, by tiles of rays (trace --no-trace), or a noisy image of random samples")
      ->check(one_of(tracing_names()));
  command->add_option("--samples", cli.samples, "Of a ray, with --tracing stochastic")
      ->check(in_range(1U, kMaxSamples));
  command->add_option("--sample-seed", cli.sample_seed, "Of the coins of --tracing stochastic");
  add_choice(command, "--triangle-test", cli.triangle_test,
             "Hit test of triangles: canonical, or their stored vertices");
  command->add_option("--box-bits", cli.box_bits, "Bits used of a stored box coordinate (a node keeps its size)")
      ->check(in_range(2U, 8U));
  add_choice(command, "--response-precision", cli.response_precision,
             "Format to which every step of a Gaussian's response is rounded");
  add_choice(command, "--skip", cli.skip,
             "Work left out that changes no bit of the image; faithful keeps the hardware's visits");
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
  o.sort_key = cli.sort_key;
  o.resume = cli.resume;
  o.inside = cli.inside;
  o.tmax_update = cli.tmax_update;
  o.checkpoint_order = cli.checkpoint_order;
  o.replay_tmax = cli.replay_tmax;
  o.child_order = cli.child_order;
  o.pop_test = cli.pop_test;
  o.sh_direction = cli.sh_dir;
  o.kernel = kernel_of(cli.kernel_radius, cli.kernel_degree);
  o.tracing = *from_name<Tracing>(cli.tracing);
  o.triangle_test = cli.triangle_test;
  o.response_precision = cli.response_precision;
  o.skips = skips_of(cli.skip);
  o.samples = cli.samples;
  o.sample_seed = cli.sample_seed;
  if (keeps_one_hit(o.tracing)) o.k = 1;
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
  return {accel, bvh_width(cli), cli.instance_bounds == InstanceBounds::box_corners, cli.box_bits, cli.layout};
}

RenderOptions render_options(const TracerCli& cli, bool quiet) {
  RenderOptions r;
  r.threads = cli.threads;
  r.linear_mapping = cli.mapping == traces::WarpMapping::linear;
  r.warp_size = cli.warp_size;
  r.quiet = quiet;
  return r;
}

std::map<std::string, std::string> option_inputs(const TracerCli& cli, bool checkpoint, AccelKind accel) {
  std::map<std::string, std::string> inputs = {{"accel", accel_name(accel)},
                                               {"k", std::to_string(keeps_one_hit(cli.tracing) ? 1 : cli.k)},
                                               {"checkpoint", checkpoint ? "on" : "off"},
                                               {"checkpoint_capacity", std::to_string(cli.checkpoint_capacity)},
                                               {"ert", fmt::format("{}", cli.ert)},
                                               {"sort_key", std::string(name_of(cli.sort_key))},
                                               {"resume", std::string(name_of(cli.resume))},
                                               {"kernel_radius", std::string(name_of(cli.kernel_radius))},
                                               {"child_order", std::string(name_of(cli.child_order))},
                                               {"tmax_update", std::string(name_of(cli.tmax_update))},
                                               {"checkpoint_order", std::string(name_of(cli.checkpoint_order))},
                                               {"replay_tmax", std::string(name_of(cli.replay_tmax))},
                                               {"inside", std::string(name_of(cli.inside))},
                                               {"sh_dir", std::string(name_of(cli.sh_dir))},
                                               {"instance_bounds", std::string(name_of(cli.instance_bounds))},
                                               {"bvh_width", std::to_string(bvh_width(cli))},
                                               {"mapping", std::string(name_of(cli.mapping))},
                                               {"warp_size", std::to_string(cli.warp_size)},
                                               {"tracing", cli.tracing},
                                               {"triangle_test", std::string(name_of(cli.triangle_test))},
                                               {"box_bits", std::to_string(cli.box_bits)},
                                               {"response_precision", std::string(name_of(cli.response_precision))}};
  if (cli.pop_test != TracerOptions{}.pop_test) inputs["pop_test"] = name_of(cli.pop_test);
  if (cli.tracing == name_of(Tracing::stochastic)) {
    inputs["samples"] = std::to_string(cli.samples);
    inputs["sample_seed"] = std::to_string(cli.sample_seed);
  }
  if (cli.kernel_degree != 2) inputs["kernel_degree"] = std::to_string(cli.kernel_degree);
  if (cli.layout != traces::NodeLayout::vulkan_sim) inputs["layout"] = name_of(cli.layout);
  inputs.merge(secondary_inputs(cli.secondary));
  return inputs;
}

}  // namespace grtx::sim
