// One stage of a search: which scenes, in which mode; what designs are there, beside the reference.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "grtx/base/declare/named_enum.h"
#include "grtx/lab/search/price.h"
#include "grtx/lab/search/search_plan.h"
#include "grtx/lab/sweep/points.h"
#include "grtx/lab/sweep/session.h"

namespace grtx::sim {

/// What a stage says of a design.
struct Verdict {
  enum class Kind : std::uint8_t {
    measured,  ///< all constraints hold
    refused,   ///< a constraint does not
    broken,    ///< no machine, tracer or mode takes the combination
    failed     ///< a trace or a simulation did not end well
  };
  Kind kind = Kind::measured;
  std::string reason;          ///< of all but measured
  double excess = 0.0;         ///< how far constraints are off, as shares of their bounds, summed
  std::vector<double> ratios;  ///< if simulated: each objective over the reference's, geometric mean over the views
};
constexpr auto enum_names(Verdict::Kind) {
  using enum Verdict::Kind;
  return std::to_array<EnumName<Verdict::Kind>>(
      {{measured, "measured"}, {refused, "refused"}, {broken, "broken"}, {failed, "failed"}});
}

/// What a stage runs: its scenes, settings and mode; no points.
SweepPlan screening_plan(const SearchPlan& search);
SweepPlan confirming_plan(const SearchPlan& search);
SweepPlan evaluation_plan(const SearchPlan& search);

class Stage {
 public:
  /// Throws Error when the reference is broken, or an objective or constraint names a cost that there is not. All
  /// references must outlive it.
  Stage(SweepPlan plan, const SearchPlan& search, const TracerRules& tracer, SweepSession& session, Prices& prices);

  enum class Dear : std::uint8_t { spared, simulated };  ///< designs whose price breaks a constraint
  /// One batch: runs what the database does not hold; with the first goes the reference. what: for the progress. Throws
  /// Error when the reference did not run, or it has no value of an objective's or a constraint's name.
  std::vector<Verdict> judge(const std::vector<Coordinates>& designs, const std::string& what,
                             Dear dear = Dear::spared);

  /// The objectives of the reference at a view.
  struct View {
    std::string scene;
    unsigned view = 0;
    std::vector<double> values;
  };
  /// After the first judge().
  std::vector<View> reference() const;
  /// Different points that were asked for.
  std::size_t points() const { return asked_.size(); }

 private:
  using Made = std::vector<PointMaker::Made>;  ///< a design at each place
  Made make(const Coordinates& design);
  void check_name(const std::string& name, const std::string& place, const std::vector<std::string>& known) const;
  void read_reference();
  /// Without simulating: whether it is broken, and what the constraints on costs say.
  Verdict look(const Made& design);
  /// The point's own line when it is not done; else ratios and constraints.
  Verdict measure(const Made& design) const;
  /// values: at each place.
  void apply(const SearchConstraint& constraint, const std::vector<double>& values,
             const std::vector<double>& reference, Verdict& verdict) const;

  SweepPlan plan_;
  const SearchPlan& search_;
  SweepSession& session_;
  Prices& prices_;
  PointMaker maker_;
  Made reference_;
  std::map<std::string, std::vector<double>> reference_values_;  ///< of objectives and constraints, at each place
  std::set<std::string> asked_;                                  ///< keys of points
};

}  // namespace grtx::sim
