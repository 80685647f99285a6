// The tracer's options on the command line, shared by `trace` and `run`.
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>

#include "grtx/apps/grtx/secondary_cli.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/frontend/tracer/tracer_options.h"

namespace grtx::sim {

struct TracerCli {
  unsigned k = 8;
  unsigned checkpoint_capacity = 1024;
  float ert = 0.001f;
  std::string sort_key = "entry";
  std::string resume = "exact";
  std::string kernel_radius = "adaptive";
  std::string child_order = "near_first";
  std::string tmax_update = "reported";
  std::string checkpoint_order = "fifo";
  std::string replay_tmax = "infinity";
  std::string inside = "skip";
  std::string sh_dir = "ray";
  std::string instance_bounds = "tight";
  std::string mapping = "tile8x4";
  std::string tracing = "multi";
  std::string triangle_test = "canonical";
  std::string response_precision = "fp32";
  unsigned box_bits = 8;
  unsigned bvh_width = 6;
  std::string skip = "faithful";
  unsigned warp_size = 32;
  unsigned threads = 0;
  SecondaryCli secondary;
};

void add_tracer_options(CLI::App* command, TracerCli& cli);
/// Throws Error for combinations that the named structure cannot do.
frontend::TracerOptions tracer_options(const TracerCli& cli, bool checkpoint, frontend::AccelKind accel);
frontend::AccelOptions accel_options(const TracerCli& cli, frontend::AccelKind accel);
frontend::RenderOptions render_options(const TracerCli& cli, bool quiet);
/// Resolved options as text, for the "inputs" of outputs and trace headers.
std::map<std::string, std::string> option_inputs(const TracerCli& cli, bool checkpoint, frontend::AccelKind accel);

}  // namespace grtx::sim
