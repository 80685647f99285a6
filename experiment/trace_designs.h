// SPDX-License-Identifier: Apache-2.0
// Traces one view with each design for each machine, what is the same for several once, and checks that all give the
// same image.
#pragma once

#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "grtx/base/files_read.h"
#include "grtx/experiment/design_comparison.h"
#include "grtx/experiment/picture_quality.h"
#include "grtx/experiment/tracer_settings.h"
#include "grtx/experiment/view_choice.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/tracer/scene_tracer.h"
#include "grtx/frontend/tracer/tracer.h"

namespace grtx::experiment {

struct TracedDesign {
  std::string path;
  frontend::TraceFile file;
  nlohmann::ordered_json statistics;  ///< tracer.*, accel.*, trace.*
};

/// How far the image of a design with an order of its own is from that of the design that speed-ups are over.
struct OtherOrder {
  std::string order;  ///< by which its hits are blended: "peak", or "entry" and the proxy
  double psnr = 0.0;  ///< dB, of the worst frame
};

/// Result of tracing all designs.
struct TracedDesigns {
  std::map<std::string, TracedDesign> designs;
  std::vector<frontend::Image> images;             ///< of the design that speed-ups are over, by frame
  bool identical = true;                           ///< images of all designs that blend in one order are bit-identical
  std::map<std::string, OtherOrder> other_orders;  ///< designs that blend in another order than that design
  std::map<std::string, PictureQuality> pictures;  ///< of each design
  frontend::TracerCounters counters;               ///< of the design that speed-ups are over
  std::string files_hash;                          ///< hash of the camera and scene files
};

/// How the tracer works for a machine.
struct MachineTracing {
  std::string name;
  TracerSettings tracer;
};

struct DesignTracing {
  std::string scene;  ///< file, or list of objects
  ViewOptions view;
  std::vector<MachineTracing> machines;  ///< at least one; kernels are those of the first
  bool several_objects = false;          ///< keep objects apart, do not merge them
  std::string folder;                    ///< receives the traces, at trace_path()
  std::set<std::string> named;           ///< options that designs leave as they are
  bool quiet = false;
  std::function<void(const FilesRead&)> opened;  ///< called with all files read, before any is written
};

/// The settings with those of a design, except options that are named in `named`.
TracerSettings design_settings(TracerSettings settings, const explore::Design& design,
                               const std::set<std::string>& named);

/// The order in which a design's hits are blended. Peaks are the same for all proxies, entries are not. Gaussians that
/// are rounded to their codes have an order of their own.
std::string order_of(const TracerSettings& settings, frontend::AccelKind kind);

/// Where a design's trace lies: NAME.grtx, or NAME.MACHINE.grtx for a machine whose trace is not that of the first.
std::string trace_path(const std::string& folder, const std::string& design, const std::string& machine = "");

/// One for each machine. Throws Error if the scene, cameras or options are not valid.
std::vector<TracedDesigns> trace_designs(const DesignTracing& tracing, const DesignComparison& comparison);

}  // namespace grtx::experiment
