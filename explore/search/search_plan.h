// SPDX-License-Identifier: Apache-2.0
// The plan of a search: scenes, settings and limits as in a sweep, plus parameters, objectives and constraints
// (docs/guide/search.md).
#pragma once

#include <string>
#include <vector>

#include "grtx/explore/sweep/plan.h"

namespace grtx::explore {

/// A parameter of the search: a configuration key, "tracer.OPTION", "design" or "machine".
struct SearchParameter {
  std::string key;
  std::vector<SweepValue> values;  ///< at least two
  bool ordered = true;             ///< neighbouring values are alike
};

/// A value of a point to minimise.
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
  bool relative = false;  ///< bound is a factor on the reference's value
};

struct SearchPlan {
  SweepPlan common;  ///< its mode is that of the screening
  std::vector<SearchParameter> parameters;
  std::vector<SearchObjective> objectives;
  std::vector<SearchConstraint> constraints;
  Coordinates reference;  ///< the rest as in `base`, [set] and [tracer]
  std::string reference_place;
  Coordinates screening;         ///< settings of the screening only
  double screening_scale = 1.0;  ///< width and height of the screening's images over those of the scenes
  std::string confirm = "cycle";
  unsigned seed = 1;
  unsigned population = 40;
  unsigned generations = 0;  ///< after the first; 0: until `candidates` is reached
  unsigned candidates = 0;   ///< minimum number of different designs; 0: given by `generations`
  double margin = 0.0;       ///< also confirms designs that would be on the front if better by this share
  bool path = true;          ///< simulate the path from the reference to the best design
};

/// Throws Error as load_plan() does.
SearchPlan load_search_plan(const std::string& path, const TracerRules& tracer);

}  // namespace grtx::explore
