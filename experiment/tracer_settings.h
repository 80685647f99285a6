// SPDX-License-Identifier: Apache-2.0
// The tracer's options by name, as used on the command line, in machines, plans and trace headers.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "grtx/experiment/secondary_settings.h"
#include "grtx/frontend/accel/accel_options.h"
#include "grtx/frontend/tracer/render_options.h"
#include "grtx/frontend/tracer/tracer_options.h"
#include "grtx/traces/modes.h"

namespace grtx::experiment {

enum class KernelRadius : std::uint8_t { adaptive, three_sigma };
constexpr auto enum_names(KernelRadius) { return names_in_order<KernelRadius>({"adaptive", "3sigma"}); }

enum class InstanceBounds : std::uint8_t { tight, box_corners };
constexpr auto enum_names(InstanceBounds) { return names_in_order<InstanceBounds>({"tight", "box_corners"}); }

struct TracerSettings {
  frontend::TracerOptions options;  ///< options that share their name with a flag; tracer_options() sets the others
  KernelRadius kernel_radius = KernelRadius::adaptive;
  unsigned kernel_degree = 2;
  InstanceBounds instance_bounds = InstanceBounds::tight;
  traces::WarpMapping mapping = traces::WarpMapping::tile8x4;
  std::string tracing = "multi";  ///< a name of Tracing
  unsigned box_bits = 8;
  traces::NodeLayout layout = traces::NodeLayout::vulkan_sim;
  std::optional<unsigned> bvh_width;  ///< none: default_width() of the layout
  unsigned warp_size = 32;
  unsigned threads = 0;  ///< 0: all
  SecondarySettings secondary;
};

/// Key and description of an option.
struct TracerOptionName {
  std::string key;
  std::string description;
};
/// All options, in the order of --help.
const std::vector<TracerOptionName>& tracer_option_names();
/// Sets the option with this key. Throws Error{"tracer", key, rule} for a value that the command line would refuse, and
/// for an unknown key.
void set_option(TracerSettings& settings, const std::string& key, const std::string& text);

frontend::Kernel kernel_of(KernelRadius radius, unsigned degree);
/// Throws Error for combinations that the acceleration structure does not support.
frontend::TracerOptions tracer_options(const TracerSettings& settings, bool checkpoint, frontend::AccelKind accel);
frontend::AccelOptions accel_options(const TracerSettings& settings, frontend::AccelKind accel);
frontend::RenderOptions render_options(const TracerSettings& settings, bool quiet);
/// Every option that trace inputs may record, as text, by key.
std::map<std::string, std::string> option_texts(const TracerSettings& settings);
/// Resolved options as text, for the "inputs" of outputs and trace headers. Options that were added later are left out
/// at their defaults, so that recorded hashes of inputs stay valid.
std::map<std::string, std::string> option_inputs(const TracerSettings& settings, bool checkpoint,
                                                 frontend::AccelKind accel);
/// Settings that a trace was made with, from Header::inputs. Throws Error naming the file `trace`.
TracerSettings traced_settings(const std::string& trace, const std::map<std::string, std::string>& inputs);

}  // namespace grtx::experiment
