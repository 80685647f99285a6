// SPDX-License-Identifier: Apache-2.0
// One stage of a search: simulates designs on its scenes in its mode and compares them with the reference.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "grtx/base/declare/named_enum.h"
#include "grtx/explore/search/price.h"
#include "grtx/explore/search/search_plan.h"
#include "grtx/explore/sweep/points.h"
#include "grtx/explore/sweep/session.h"

namespace grtx::explore {

/// Result of a design in a stage.
struct Verdict {
  enum class Kind : std::uint8_t {
    measured,  ///< all constraints hold
    refused,   ///< a constraint is violated
    broken,    ///< the machine, tracer or mode does not support the combination
    failed     ///< a trace or a simulation failed
  };
  Kind kind = Kind::measured;
  std::string reason;          ///< why it is not `measured`
  double excess = 0.0;         ///< sum of the constraint violations, each relative to its bound
  std::vector<double> ratios;  ///< if simulated: objective / reference's, geometric mean over the views
};
constexpr auto enum_names(Verdict::Kind) {
  using enum Verdict::Kind;
  return std::to_array<EnumName<Verdict::Kind>>(
      {{measured, "measured"}, {refused, "refused"}, {broken, "broken"}, {failed, "failed"}});
}

/// Scenes, settings and mode of a stage; without points.
SweepPlan screening_plan(const SearchPlan& search);
SweepPlan confirming_plan(const SearchPlan& search);
SweepPlan evaluation_plan(const SearchPlan& search);

class Stage {
 public:
  /// All reference arguments must outlive the stage. Throws Error if the reference design is broken, or an objective or
  /// constraint names an unknown cost.
  Stage(SweepPlan plan, const SearchPlan& search, const TracerRules& tracer, SweepSession& session, Prices& prices);

  enum class CostlyDesigns : std::uint8_t {
    skip,
    simulate
  };  ///< whether to simulate designs whose cost breaks a constraint
  /// Judges a batch of designs: runs those not in the database; the first batch also runs the reference. what: label of
  /// the progress bar. Throws Error if the reference did not run, or lacks a value of an objective or constraint.
  std::vector<Verdict> judge(const std::vector<Coordinates>& designs, const std::string& what,
                             CostlyDesigns costly = CostlyDesigns::skip);

  /// The objectives of the reference at a view.
  struct View {
    std::string scene;
    unsigned view = 0;
    std::vector<double> values;
  };
  /// Valid after the first judge().
  std::vector<View> reference() const;
  /// Number of different points requested.
  std::size_t points() const { return requested_.size(); }

 private:
  using DesignPoints = std::vector<PointMaker::TracedPoint>;  ///< a design's points, one per place (scene and view)
  DesignPoints make(const Coordinates& design);
  void check_name(const std::string& name, const std::string& place, const std::vector<std::string>& known) const;
  void read_reference();
  /// Checks without simulating: whether the design is broken, and the constraints on costs.
  Verdict check_costs(const DesignPoints& design);
  /// Verdict of a simulated design: its failure, or else ratios and constraints.
  Verdict measure(const DesignPoints& design) const;
  /// values: one per place.
  void apply(const SearchConstraint& constraint, const std::vector<double>& values,
             const std::vector<double>& reference, Verdict& verdict) const;

  SweepPlan plan_;
  const SearchPlan& search_;
  SweepSession& session_;
  Prices& prices_;
  PointMaker maker_;
  DesignPoints reference_;
  std::map<std::string, std::vector<double>> reference_values_;  ///< by name of objective or constraint, one per place
  std::set<std::string> requested_;                              ///< keys of points
};

}  // namespace grtx::explore
