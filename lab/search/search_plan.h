// The plan of a search: a sweep's scenes, settings and limits, and what may be chosen, what is wanted and what must
// hold (docs/guide/search.md).
#pragma once

#include <string>
#include <vector>

#include "grtx/lab/sweep/plan.h"

namespace grtx::sim {

/// One thing that the search may choose: a configuration key, "tracer.OPTION" or "design".
struct SearchParameter {
  std::string key;
  std::vector<SweepValue> values;  ///< at least two
  bool ordered = true;             ///< neighbours in the list are alike
};

/// A value of a point, to be as small as possible.
struct SearchObjective {
  std::string value;  ///< a statistic or cost.*
  std::string place;  ///< "line N"
};

struct SearchConstraint {
  std::string text;  ///< as written
  std::string place;
  std::string value;      ///< a statistic or cost.*
  bool at_most = true;    ///< else at least
  double bound = 0.0;     ///< a number, or a factor on the reference's value
  bool relative = false;  ///< to the reference
};

struct SearchPlan {
  SweepPlan common;  ///< mode: of the screening
  std::vector<SearchParameter> parameters;
  std::vector<SearchObjective> objectives;
  std::vector<SearchConstraint> constraints;
  Coordinates reference;  ///< what it does not name is as `base`, [set] and [tracer] say
  std::string reference_place;
  Coordinates screening;  ///< settings that only the screening has
  std::string confirm = "cycle";
  unsigned seed = 1;
  unsigned population = 40;
  unsigned generations = 0;  ///< after the first; 0: as `candidates` says
  unsigned candidates = 0;   ///< different designs to look at, at least; 0: as `generations` says
  double margin = 0.0;       ///< designs that this share could bring onto the front are confirmed too
  bool path = true;          ///< simulate the way from the reference to the best design
};

/// Errors as load_plan().
SearchPlan load_search_plan(const std::string& path, const TracerRules& tracer);

}  // namespace grtx::sim
