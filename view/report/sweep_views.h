// Points of a sweep as a report compares them: within one view of a scene, and over all views. Points of different
// views trace other rays, so a front of both would compare nothing.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "grtx/view/report/run_results.h"
#include "grtx/view/report/sweep_results.h"

namespace grtx::sim {

// Values of a sweep's points, as `grtx sweep` names them.
inline constexpr const char* kTime = "gpu.time_us";
inline constexpr const char* kArea = "cost.mm2";
inline constexpr const char* kEnergy = "gpu.energy_nj_per_ray";

/// A point of the database that is done, or what the same machine, design and coordinates have over all views.
struct ShownPoint {
  std::int64_t id = 0;          ///< of the database; of a mean below 0
  std::string label;            ///< "#12", of a mean "mean 3"
  std::size_t view = 0;         ///< in SweepViews::views
  std::size_t keys = 0;         ///< machine, options and coordinates without the view: the same in all views
  std::size_t machine = 0;      ///< the same with the design
  std::vector<std::size_t> of;  ///< in SweepResults::points: one, or one a view
  bool on_area = false;         ///< on the front of area and time of its view
  bool on_energy = false;       ///< on that of energy and time

  bool on_front() const { return on_area || on_energy; }
};

/// What speed-ups are over. A ratio is of designs on one machine with the same keys, or of keys within one design of
/// one machine, never of both.
struct SpeedupOver {
  std::string design;       ///< with the keys of each point; "": of one ShownPoint::machine
  std::size_t machine = 0;  ///< when no design is named

  bool operator==(const SpeedupOver&) const = default;
};

/// What a point is of, without its scene's and design's names.
Subject subject_of(const SweepResults& results, const ReportedPoint& point);
/// Equal of points that differ in their mode alone.
std::string but_for_mode(const SweepResults& results, const ReportedPoint& point);

struct SweepView {
  std::string title;      ///< "hall, view 2", "all 6 views"
  std::size_t views = 1;  ///< more: points are geometric means over so many
  bool is_mean() const { return views > 1; }
};

class SweepViews {
 public:
  explicit SweepViews(const SweepResults& results);

  /// With several views of one mode their mean comes first, of the points that have all of them.
  const std::vector<SweepView>& views() const { return views_; }
  const std::vector<ShownPoint>& points() const { return points_; }
  /// Coordinates with more than one value, without the view.
  const std::vector<std::string>& varying() const { return varying_; }

  /// A mean's value is the geometric mean; NaN when a point has none.
  double value(const ShownPoint& point, const std::string& name) const;
  /// Sum over the points of a mean.
  double sum(const ShownPoint& point, const std::string& name) const;
  const ReportedPoint& first(const ShownPoint& point) const { return results_.points[point.of.front()]; }
  /// What sets a point apart from the others: all coordinates that vary when these are few, else those that differ from
  /// what most points have, four at the most.
  std::string name(const ReportedPoint& point) const;
  /// As a bar or a mark is called: "#12 grtx, l1.bytes = 65536".
  std::string full_label(const ShownPoint& point) const;
  /// At first: with several designs the baseline's, or the first's, with the keys of each point; else the first point.
  SpeedupOver reference() const;
  /// nullptr when its view has no such point, or none that it may be compared with.
  const ShownPoint* over(const ShownPoint& point, const SpeedupOver& reference) const;
  /// Time of that point over the point's; NaN without one.
  double speedup(const ShownPoint& point, const SpeedupOver& reference) const;
  /// Of that ratio; what both simulations have in common is not known here.
  std::optional<Interval> speedup_interval(const ShownPoint& point, const SpeedupOver& reference) const;
  /// Of a time that was estimated, µs; nothing of a mean.
  std::optional<Interval> time_interval(const ShownPoint& point) const;

 private:
  nlohmann::ordered_json coordinate(const ReportedPoint& point, const std::string& name) const;
  void find_varying();
  void find_fronts();

  const SweepResults& results_;
  std::vector<SweepView> views_;
  std::vector<ShownPoint> points_;
  std::vector<std::string> varying_;
  std::vector<nlohmann::ordered_json> commonest_;  ///< value of each of varying_
};

}  // namespace grtx::sim
