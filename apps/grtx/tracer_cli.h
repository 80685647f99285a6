// The tracer's options on the command line, shared by `trace` and `run`.
#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "grtx/apps/grtx/secondary_cli.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/frontend/tracer/tracer_options.h"
#include "grtx/traces/modes.h"

namespace grtx::sim {

enum class KernelRadius : std::uint8_t { adaptive, three_sigma };
constexpr auto enum_names(KernelRadius) {
  using enum KernelRadius;
  return std::to_array<EnumName<KernelRadius>>({{adaptive, "adaptive"}, {three_sigma, "3sigma"}});
}

enum class InstanceBounds : std::uint8_t { tight, box_corners };
constexpr auto enum_names(InstanceBounds) {
  using enum InstanceBounds;
  return std::to_array<EnumName<InstanceBounds>>({{tight, "tight"}, {box_corners, "box_corners"}});
}

struct TracerCli {
  unsigned k = 8;
  unsigned checkpoint_capacity = 1024;
  float ert = 0.001f;
  frontend::SortKey sort_key = frontend::SortKey::entry;
  frontend::Resume resume = frontend::Resume::exact;
  KernelRadius kernel_radius = KernelRadius::adaptive;
  unsigned kernel_degree = 2;
  frontend::ChildOrder child_order = frontend::ChildOrder::near_first;
  frontend::PopTest pop_test = frontend::PopTest::on;
  frontend::TmaxUpdate tmax_update = frontend::TmaxUpdate::reported;
  frontend::CheckpointOrder checkpoint_order = frontend::CheckpointOrder::fifo;
  frontend::ReplayTmax replay_tmax = frontend::ReplayTmax::infinity;
  frontend::InsideRule inside = frontend::InsideRule::skip;
  frontend::ShDirection sh_dir = frontend::ShDirection::ray;
  InstanceBounds instance_bounds = InstanceBounds::tight;
  traces::WarpMapping mapping = traces::WarpMapping::tile8x4;
  std::string tracing = "multi";  ///< a name of Tracing, or "tiles"
  unsigned samples = frontend::TracerOptions{}.samples;
  std::uint32_t sample_seed = frontend::TracerOptions{}.sample_seed;
  frontend::TriangleTest triangle_test = frontend::TriangleTest::canonical;
  frontend::ResponsePrecision response_precision = frontend::ResponsePrecision::fp32;
  unsigned box_bits = 8;
  traces::NodeLayout layout = traces::NodeLayout::vulkan_sim;
  std::optional<unsigned> bvh_width;  ///< none: as many children as a line of the layout holds
  frontend::SkipSet skip = frontend::SkipSet::faithful;
  unsigned warp_size = 32;
  unsigned threads = 0;
  SecondaryCli secondary;
};

void add_kernel_degree(CLI::App* command, unsigned& degree);
frontend::Kernel kernel_of(KernelRadius radius, unsigned degree);
void add_tracer_options(CLI::App* command, TracerCli& cli);
/// Throws Error for combinations that the named structure cannot do.
frontend::TracerOptions tracer_options(const TracerCli& cli, bool checkpoint, frontend::AccelKind accel);
frontend::AccelOptions accel_options(const TracerCli& cli, frontend::AccelKind accel);
frontend::RenderOptions render_options(const TracerCli& cli, bool quiet);
/// Resolved options as text, for the "inputs" of outputs and trace headers. pop_test is left out at its default, so
/// that hashes of inputs on record stay.
std::map<std::string, std::string> option_inputs(const TracerCli& cli, bool checkpoint, frontend::AccelKind accel);

}  // namespace grtx::sim
