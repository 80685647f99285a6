#include "grtx/apps/grtx/tracer_cli.h"

#include <fmt/format.h>

#include <algorithm>
#include <type_traits>

#include "grtx/apps/grtx/options.h"
#include "grtx/base/error.h"
#include "grtx/traces/checkpoint_bins.h"

namespace grtx::sim {

using namespace frontend;

namespace {

constexpr const char* kKernelDegree =
    "n of a Gaussian's response exp(-4.5 (d/3)^n), d in standard deviations: 2 is 3DGS, 4 what 3DGRT trains by default";

/// With the renderer that makes no trace.
std::vector<std::string> tracing_names() {
  std::vector<std::string> names = names_of<Tracing>();
  names.push_back("tiles");
  return names;
}

unsigned bvh_width(const TracerCli& cli) { return cli.bvh_width.value_or(traces::default_width(cli.layout)); }

/// Calls visit(name, value, description[, check]) for each option that a trace's inputs name, in the order of --help.
/// cli may be const.
template <typename Cli, typename Visit>
void visit_options(Cli& cli, Visit&& visit) {
  auto& o = cli.options;
  visit("k", o.k, "k-buffer entries a ray", in_range(1U, kMaxK));
  visit("checkpoint-capacity", o.checkpoint_capacity, "Entries of one checkpoint buffer of a ray",
        in_range(1U, 65535U));
  visit("checkpoint-bins", o.checkpoint_bins,
        "Near lists of a ray by distance, and a far one, of --checkpoint-capacity entries each; 0: two buffers",
        in_range(0U, traces::kMaxCheckpointBins));
  visit("below-instance", o.below_instance,
        "Nodes of an instance beyond t_max: checkpointed, or visited, and a hit goes to the eviction buffer");
  visit("ert", o.ert, "Transmittance below which a ray ends", in_range(0.0, 1.0));
  visit("sort-key", o.sort_key, "Distance that orders a ray's hits");
  visit("resume", o.resume, "How a round continues: (t, id) order, or the paper's t_min < t");
  visit("kernel-radius", cli.kernel_radius,
        "Radius at which a Gaussian ends: by its opacity, or three standard deviations");
  visit("kernel-degree", cli.kernel_degree, kKernelDegree, CLI::IsMember({2U, 4U}));
  visit("child-order", o.child_order, "Order in which hit children are visited; a machine may choose another");
  visit(
      "pop-test", o.pop_test,
      "Whether a popped node is compared with t_max before its fetch (stack entries then hold t); a machine may choose "
      "another");
  visit("tmax-update", o.tmax_update, "t_max after an any-hit: the reported hit's t, or the k-th");
  visit("checkpoint-order", o.checkpoint_order, "Order in which replay reads the source buffer");
  visit("replay-tmax", o.replay_tmax, "t_max at the start of a round with a preloaded k-buffer");
  visit("inside", o.inside, "Gaussians whose proxy holds the ray origin: skipped, or hit at distance 0");
  visit("sh-dir", o.sh_direction, "Direction in which the spherical harmonics are evaluated");
  visit("instance-bounds", cli.instance_bounds,
        "Boxes of instances in the world: of the proxy, or of its box's corners");
  visit("layout", cli.layout, "How nodes lie in memory (docs/model/node-image.md)");
  visit("bvh-width", cli.bvh_width, "Children of an internal node; with --layout compact 8 by default",
        in_range(2U, 8U));
  visit("mapping", cli.mapping, "How pixels form warps; tiles of 16, 8, 4: 4x4, 4x2, 2x2");
  visit("warp-size", cli.warp_size, "Rays of a warp", one_of({"4", "8", "16", "32"}));
  visit("tracing", cli.tracing,
        "multi: rounds of k hits; single: one round, then a sort (--k holds all hits); closest: a round a hit; tiles: "
        "the same image without rounds (trace --no-trace); list: one "
        "traversal, all hits to a list of the ray in memory, blended in batches of the nearest",
        one_of(tracing_names()));
  visit("list-capacity", o.list_capacity,
        "Hits that the list of a ray holds, with --tracing list; more take a further "
        "pass",
        in_range(1U, kMaxK));
  visit("triangle-test", o.triangle_test, "Hit test of triangles: canonical, or their stored vertices");
  visit("box-bits", cli.box_bits, "Bits used of a stored box coordinate (a node keeps its size)", in_range(2U, 8U));
  visit("response-precision", o.response_precision, "Format to which every step of a Gaussian's response is rounded");
}

}  // namespace

void add_kernel_degree(CLI::App* command, unsigned& degree) {
  command->add_option("--kernel-degree", degree, kKernelDegree)->check(CLI::IsMember({2U, 4U}));
}

void add_tracer_options(CLI::App* command, TracerCli& cli) {
  visit_options(cli,
                [&]<typename Value>(const std::string& name, Value& value, const char* description, auto... check) {
                  const std::string flag = "--" + name;
                  if constexpr (NamedEnum<Value>) {
                    add_choice(command, flag, value, description);
                  } else {
                    CLI::Option* option = command->add_option(flag, value, description);
                    (option->check(check), ...);
                  }
                  if (name == "bvh-width") command->get_option(flag)->default_str("6");
                  if (name == "warp-size") add_secondary_options(command, cli.secondary);
                });
  command->add_option("--threads", cli.threads, "Threads; 0 takes all");
}

Kernel kernel_of(KernelRadius radius, unsigned degree) { return {radius == KernelRadius::adaptive, degree}; }

TracerOptions tracer_options(const TracerCli& cli, bool checkpoint, AccelKind accel) {
  if (cli.tracing == "tiles") {
    throw Error("--tracing", "tiles", "visits what it likes and renders only: it needs trace --no-trace");
  }
  TracerOptions o = cli.options;
  o.checkpoint = checkpoint;
  o.kernel = kernel_of(cli.kernel_radius, cli.kernel_degree);
  o.tracing = *from_name<Tracing>(cli.tracing);
  if (o.tracing == Tracing::closest) o.k = 1;
  if (o.tracing == Tracing::list) o.k = o.list_capacity;
  if (checkpoint && o.tracing != Tracing::multi) {
    throw Error("--tracing", cli.tracing, "has no rounds to resume: checkpointing needs --tracing multi");
  }
  if (o.checkpoint_bins == 1) throw Error("--checkpoint-bins", "1", "is one list: 0 takes two buffers, 2 or more bins");
  if (o.checkpoint_bins != 0 && o.checkpoint_order != CheckpointOrder::fifo) {
    throw Error("--checkpoint-order", std::string(name_of(o.checkpoint_order)),
                "is an order of two buffers: --checkpoint-bins has one of its own");
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
  RenderOptions r{.threads = cli.threads,
                  .linear_mapping = cli.mapping == traces::WarpMapping::linear,
                  .warp_size = cli.warp_size,
                  .quiet = quiet};
  return r;
}

std::map<std::string, std::string> option_texts(const TracerCli& cli) {
  std::map<std::string, std::string> texts;
  visit_options(cli, [&]<typename Value>(std::string name, const Value& value, const char*, auto...) {
    std::replace(name.begin(), name.end(), '-', '_');
    if constexpr (NamedEnum<Value>) {
      texts[name] = name_of(value);
    } else if constexpr (std::is_same_v<Value, std::optional<unsigned>>) {
      texts[name] = std::to_string(bvh_width(cli));
    } else {
      texts[name] = fmt::format("{}", value);
    }
  });
  return texts;
}

std::map<std::string, std::string> option_inputs(const TracerCli& cli, bool checkpoint, AccelKind accel) {
  std::map<std::string, std::string> inputs = option_texts(cli);
  const std::map<std::string, std::string> defaults = option_texts({});
  for (const char* later : {"pop_test", "kernel_degree", "layout", "checkpoint_bins", "below_instance"}) {
    if (inputs.at(later) == defaults.at(later)) inputs.erase(later);
  }
  if (!checkpoint) {
    inputs.erase("checkpoint_bins");
    inputs.erase("below_instance");
  }
  if (cli.tracing == name_of(Tracing::closest)) inputs["k"] = "1";
  if (cli.tracing == name_of(Tracing::list)) {
    inputs["k"] = inputs.at("list_capacity");
  } else {
    inputs.erase("list_capacity");
  }
  inputs["accel"] = accel_name(accel);
  inputs["checkpoint"] = checkpoint ? "on" : "off";
  inputs.merge(secondary_inputs(cli.secondary));
  return inputs;
}

}  // namespace grtx::sim
