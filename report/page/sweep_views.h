// SPDX-License-Identifier: Apache-2.0
// Groups the points of a sweep for comparison: within one view of a scene, and as means over all views. Points of
// different views trace different rays, so they must not share a front.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "grtx/report/page/run_results.h"
#include "grtx/report/page/sweep_results.h"

namespace grtx::report {

// Names of values in a sweep database.
inline constexpr const char* kTime = "gpu.time_us";
inline constexpr const char* kArea = explore::kChipArea;
inline constexpr const char* kEnergy = "gpu.energy_nj_per_ray";

/// A finished point of the database, or the mean over all views for one machine, design and coordinates.
struct ShownPoint {
  std::int64_t id = 0;      ///< id in the database; negative for a mean
  std::string label;        ///< "#12"; for a mean "mean 3"
  std::size_t view = 0;     ///< index in SweepViews::views()
  std::size_t setting = 0;  ///< number of the combination of machine, options and coordinates; the same in all views
  std::size_t machine = 0;  ///< number of the combination of `setting` and design
  std::size_t varied = 0;   ///< number of the combination of design and coordinates; the same on all machines
  std::vector<std::size_t> points;  ///< indices in SweepResults::points: one, or one per view for a mean
  bool on_area = false;             ///< on its view's Pareto front of the sweep's area and time
  bool on_energy = false;           ///< on its view's Pareto front of energy and time

  bool on_front() const { return on_area || on_energy; }
};

/// The reference of speed-ups. Compares either designs with the same keys on one machine, or keys within one design on
/// one machine, or machines at one design and the same varied keys, never two of them at once.
struct SpeedupOver {
  std::string design;       ///< reference design, with the keys of each point; "": the point `machine`
  std::size_t machine = 0;  ///< ShownPoint::machine of the reference, if design is ""
  std::string on = "";      ///< reference machine by name, with design and varied keys of each point; "": not machines

  bool operator==(const SpeedupOver&) const = default;
};

/// "the chip" or "an RT unit", for the area that a front is over.
std::string owner_of(const std::string& area);

/// Subject of a point, without names of scene and design.
Subject subject_of(const SweepResults& results, const ReportedPoint& point);
/// Key that is equal for points that differ only in their mode.
std::string but_for_mode(const SweepResults& results, const ReportedPoint& point);

struct SweepView {
  std::string title;      ///< "hall, view 2", "all 6 views"
  std::size_t views = 1;  ///< number of views; above 1: points are geometric means over them
  bool is_mean() const { return views > 1; }
};

class SweepViews {
 public:
  explicit SweepViews(const SweepResults& results);

  /// For each mode, first the mean over all views (only points that have all of them), then the views.
  const std::vector<SweepView>& views() const { return views_; }
  const std::vector<ShownPoint>& points() const { return points_; }
  /// Coordinates with more than one value, except the view.
  const std::vector<std::string>& varying() const { return varying_; }

  /// Value of a point, or geometric mean, of a share the arithmetic one; NaN if missing.
  double value(const ShownPoint& point, const std::string& name) const;
  /// The area that the front is over, SweepResults::area.
  double area(const ShownPoint& point) const { return value(point, results_.area()); }
  /// The view's Pareto front of time and another value, as indices in points().
  std::vector<std::size_t> front(std::size_t view, const std::string& cost) const;
  /// Sum over the points of a mean; missing values count as 0.
  double sum(const ShownPoint& point, const std::string& name) const;
  const ReportedPoint& first(const ShownPoint& point) const { return results_.points[point.points.front()]; }
  enum class Named : std::uint8_t { briefly, all };
  /// Name that distinguishes a point: all varying coordinates if there are few, else those that differ from the most
  /// common values, briefly at most four.
  std::string name(const ReportedPoint& point, Named named = Named::briefly) const;
  /// Label of a bar or mark: "#12 grtx, l1.bytes = 65536".
  std::string full_label(const ShownPoint& point) const;
  /// Of the first view the point with the least of a value, of equal ones the first on a front: there it has a name;
  /// nullptr if none has the value.
  const ShownPoint* least(const std::string& value_name) const;
  /// Initial reference. With several designs: baseline, or else the first design. With one design: the first machine
  /// of several, or else the first point.
  SpeedupOver reference() const;
  /// The reference point for `point`; nullptr if its view has none that is comparable.
  const ShownPoint* over(const ShownPoint& point, const SpeedupOver& reference) const;
  /// Time of the reference point / time of the point; NaN without a reference.
  double speedup(const ShownPoint& point, const SpeedupOver& reference) const;
  /// Conservative interval of the speed-up: correlation of the two simulations is not known here.
  std::optional<Interval> speedup_interval(const ShownPoint& point, const SpeedupOver& reference) const;
  /// Interval of an estimated time, µs; nullopt for a mean.
  std::optional<Interval> time_interval(const ShownPoint& point) const;

 private:
  nlohmann::ordered_json coordinate(const ReportedPoint& point, const std::string& name) const;
  void find_varying();
  void find_fronts();

  const SweepResults& results_;
  std::vector<SweepView> views_;
  std::vector<ShownPoint> points_;
  std::vector<std::string> varying_;
  std::vector<nlohmann::ordered_json> commonest_;  ///< most common value of each of varying_
};

}  // namespace grtx::report
