// Traces one view with each design and checks that all give the same image.
#pragma once

#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/base/files_read.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/tracer/scene_tracer.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/study/design_comparison.h"
#include "grtx/study/tracer_settings.h"
#include "grtx/study/view_choice.h"

namespace grtx::sim {

struct TracedDesign {
  std::string path;
  frontend::TraceFile file;
  nlohmann::ordered_json statistics;  ///< tracer.*, accel.*, trace.*
};

/// Result of tracing all designs.
struct TracedDesigns {
  std::map<std::string, TracedDesign> designs;
  std::vector<frontend::Image> images;  ///< of the first design, by frame
  bool identical = true;                ///< images of all designs are bit-identical
  frontend::TracerCounters counters;    ///< of the last design; how rays end is the same in all
  std::string files_hash;               ///< hash of the camera and scene files
};

struct DesignTracing {
  std::string scene;  ///< file, or list of objects
  ViewOptions view;
  TracerSettings tracer;
  bool several_objects = false;  ///< keep objects apart, do not merge them
  std::string folder;            ///< receives NAME.grtx for each design
  bool quiet = false;
  std::function<void(const FilesRead&)> opened;  ///< called with all files read, before any is written
};

/// Throws Error if the scene, cameras or options are not valid.
TracedDesigns trace_designs(const DesignTracing& tracing, const DesignComparison& comparison);

}  // namespace grtx::sim
