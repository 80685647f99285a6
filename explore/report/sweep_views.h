// Points of a sweep as a report compares them: within one view of a scene, and over all views. Points of different
// views trace other rays, so a front of both would compare nothing.
#pragma once

#include <string>
#include <vector>

#include "grtx/explore/report/sweep_results.h"

namespace grtx::sim {

// Values of a sweep's points, as `grtx sweep` names them.
inline constexpr const char* kTime = "gpu.time_us";
inline constexpr const char* kArea = "cost.mm2";
inline constexpr const char* kEnergy = "gpu.energy_nj_per_ray";

/// A point of the database that is done, or what the same design and coordinates have over all views.
struct ShownPoint {
  std::int64_t id = 0;          ///< of the database; of a mean below 0
  std::string label;            ///< "#12", of a mean "mean 3"
  std::size_t view = 0;         ///< in SweepViews::views
  std::size_t machine = 0;      ///< design and coordinates without the view: the same in all views
  std::vector<std::size_t> of;  ///< in SweepResults::points: one, or one a view
  bool on_area = false;         ///< on the front of area and time of its view
  bool on_energy = false;       ///< on that of energy and time

  bool on_front() const { return on_area || on_energy; }
};

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
  /// The point that others are compared with at first: the first baseline, else the first point, of the first view.
  std::size_t reference() const;
  /// Time of that design and coordinates in the point's view over the point's time; NaN without one.
  double speedup(const ShownPoint& point, std::size_t machine) const;

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
