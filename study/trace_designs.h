// One view traced with each design: their traces, and whether they see the same picture.
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

/// What tracing all designs gave.
struct TracedDesigns {
  std::map<std::string, TracedDesign> designs;
  std::vector<frontend::Image> images;  ///< of the first, by frame
  bool identical = true;                ///< all images, to the bit
  frontend::TracerCounters counters;    ///< of the last; rays end alike in each
  std::string files_hash;               ///< of what cameras and scene were read from
};

struct DesignTracing {
  std::string scene;  ///< file, or list of objects
  ViewOptions view;
  TracerSettings tracer;
  bool several_objects = false;  ///< as such, not in one scene
  std::string folder;            ///< for NAME.grtx of each design
  bool quiet = false;
  std::function<void(const FilesRead&)> opened;  ///< called with all files that were read, before any is written
};

/// Throws Error.
TracedDesigns trace_designs(const DesignTracing& tracing, const DesignComparison& comparison);

}  // namespace grtx::sim
