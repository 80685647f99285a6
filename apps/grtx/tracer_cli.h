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
constexpr auto enum_names(KernelRadius) { return names_in_order<KernelRadius>({"adaptive", "3sigma"}); }

enum class InstanceBounds : std::uint8_t { tight, box_corners };
constexpr auto enum_names(InstanceBounds) { return names_in_order<InstanceBounds>({"tight", "box_corners"}); }

struct TracerCli {
  frontend::TracerOptions options;  ///< what --name has under the same name; the rest by tracer_options()
  KernelRadius kernel_radius = KernelRadius::adaptive;
  unsigned kernel_degree = 2;
  InstanceBounds instance_bounds = InstanceBounds::tight;
  traces::WarpMapping mapping = traces::WarpMapping::tile8x4;
  std::string tracing = "multi";  ///< a name of Tracing, or "tiles"
  unsigned box_bits = 8;
  traces::NodeLayout layout = traces::NodeLayout::vulkan_sim;
  std::optional<unsigned> bvh_width;  ///< none: as many children as a line of the layout holds
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
/// Every option that a trace's inputs may name, as text, by name with _ for -.
std::map<std::string, std::string> option_texts(const TracerCli& cli);
/// Resolved options as text, for the "inputs" of outputs and trace headers. Options that came later are left out at
/// their defaults, so that hashes of inputs on record stay.
std::map<std::string, std::string> option_inputs(const TracerCli& cli, bool checkpoint, frontend::AccelKind accel);

}  // namespace grtx::sim
