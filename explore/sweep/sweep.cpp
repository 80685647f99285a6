// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/sweep/sweep.h"

#include <deque>
#include <filesystem>
#include <map>

#include "grtx/base/atomic_file.h"
#include "grtx/base/json.h"
#include "grtx/base/progress.h"
#include "grtx/explore/sweep/dominance.h"
#include "grtx/explore/sweep/trace_queue.h"

namespace grtx::explore {
namespace {

/// Schedules tasks: points wait for their trace, points and traces for a free job.
class TaskScheduler {
 public:
  TaskScheduler(const SweepPoints& all, SweepDatabase& database, const SweepSetting& setting,
                std::set<std::string>& sound_traces)
      : database_(database), setting_(setting), sound_traces_(sound_traces) {
    for (const auto& trace : all.traces) traces_[trace->key] = trace.get();
    const std::vector<std::string> statuses = database.statuses_of(all.points);
    for (std::size_t i = 0; i < statuses.size(); ++i) {
      if (statuses[i] == "pending") pending_.push_back(&all.points[i]);
    }
  }

  std::size_t pending() const { return pending_.size(); }

  /// Sorts pending points into ready and waiting; records those that cannot run. Returns the number of the latter.
  std::size_t begin() {
    std::vector<SweepDatabase::Refusal> refused;
    std::map<std::string, std::string> status_of;  // by trace key; cache
    for (const SweepPoint* point : pending_) {
      if (!point->broken.empty()) {
        refused.push_back({point, point->broken});
        continue;
      }
      const std::string& key = point->trace_key;
      const auto [known, is_new] = status_of.try_emplace(key);
      if (is_new) known->second = database_.status_of_trace(key);
      const std::string& status = known->second;
      if (sound_traces_.contains(key)) {
        ready_.push_back(point);
      } else if (status == "done" || status == "pending") {  // for a done trace, the task verifies the file
        if (waiting_[key].empty()) traces_to_make_.add(*traces_.at(key));
        waiting_[key].push_back(point);
      } else {
        refused.push_back({point, "trace: " + database_.reason_of_trace(key)});
      }
    }
    database_.refuse(refused);
    return refused.size();
  }

  /// Takes up to `places` jobs; points first, so that finished traces are used soon.
  std::vector<Job> take(std::size_t places, std::size_t most_tasks) {
    std::vector<Job> jobs;
    while (jobs.size() < places && !ready_.empty()) {
      jobs.push_back({point_task(*ready_.front(), setting_.program, setting_.traces, setting_.limits)});
      ready_.pop_front();
    }
    while (jobs.size() < places && !traces_to_make_.empty()) {
      Job& job = jobs.emplace_back();
      for (const SweepTrace* trace : traces_to_make_.take(places - jobs.size() + 1, most_tasks)) {
        job.push_back(trace_task(*trace, setting_.program, setting_.traces, setting_.limits));
      }
    }
    return jobs;
  }

  const TraceWork& work() const { return work_; }

  /// Records an outcome. Returns the number of points that ended with it.
  std::size_t end(const TaskOutcome& outcome) {
    database_.record(outcome);
    if (outcome.structures_built) work_.add({1, *outcome.structures_built});
    if (!outcome.is_trace) {
      if (outcome.status == "pending") recheck_trace_of(outcome.key);
      return 1;
    }
    const std::vector<const SweepPoint*> points = waiting_[outcome.key];
    waiting_.erase(outcome.key);
    if (outcome.status == "done") {
      sound_traces_.insert(outcome.key);
      ready_.insert(ready_.end(), points.begin(), points.end());
      return 0;
    }
    std::vector<SweepDatabase::Refusal> refused;
    for (const SweepPoint* point : points) refused.push_back({point, "trace: " + outcome.reason});
    database_.refuse(refused);
    return points.size();
  }

 private:
  void recheck_trace_of(const std::string& key) {
    for (const SweepPoint* point : pending_) {
      if (point->key == key) sound_traces_.erase(point->trace_key);
    }
  }

  SweepDatabase& database_;
  const SweepSetting& setting_;
  std::set<std::string>& sound_traces_;
  std::map<std::string, const SweepTrace*> traces_;
  std::vector<const SweepPoint*> pending_;
  std::deque<const SweepPoint*> ready_;
  TraceQueue traces_to_make_;
  std::map<std::string, std::vector<const SweepPoint*>> waiting_;  ///< by trace key
  TraceWork work_;
};

}  // namespace

TraceWork run_points(const SweepPoints& all, SweepDatabase& database, Launcher& launcher, const WorkFolder& work,
                     const SweepSetting& setting, std::set<std::string>& sound_traces) {
  TaskScheduler scheduler(all, database, setting, sound_traces);
  Progress progress(setting.what, scheduler.pending(), "points", setting.quiet || scheduler.pending() == 0);
  progress.add(scheduler.begin());
  std::size_t under_way = 0;
  for (;;) {
    if (const std::vector<Job> jobs = scheduler.take(launcher.free(), launcher.most_tasks()); !jobs.empty()) {
      Job tasks;
      for (const Job& job : jobs) tasks.insert(tasks.end(), job.begin(), job.end());
      for (const Task& task : tasks) write_file(work.description(task.key), exact_json_text(task.description));
      database.set_running(tasks);
      launcher.launch(jobs);
      under_way += tasks.size();
    }
    if (under_way == 0) break;
    for (const TaskOutcome& outcome : launcher.collect()) {
      --under_way;
      progress.add(scheduler.end(outcome));
      std::error_code ignored;
      std::filesystem::remove(work.result(outcome.key), ignored);
    }
  }
  progress.finish();
  return scheduler.work();
}

std::vector<SweepPoint> pareto_front(const std::vector<SweepPoint>& points, SweepDatabase& database,
                                     const std::string& area) {
  std::map<std::string, std::vector<std::size_t>> groups;  // by scene and view
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (database.status_of_point(points[i].key) != "done") continue;
    const auto& coordinates = points[i].coordinates;
    groups[points[i].scene + " " + (coordinates.contains("view") ? json_text(coordinates.at("view")) : "")].push_back(
        i);
  }
  std::vector<bool> chosen(points.size(), false);
  for (const auto& [name, members] : groups) {
    std::vector<std::vector<double>> costs;
    for (const std::size_t i : members) {
      costs.push_back({database.value(points[i].key, "gpu.time_us"), database.value(points[i].key, area)});
    }
    const std::vector<bool> on_front = non_dominated(costs);
    for (std::size_t m = 0; m < members.size(); ++m) chosen[members[m]] = on_front[m];
  }
  std::vector<SweepPoint> front;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (chosen[i]) front.push_back(points[i]);
  }
  return front;
}

}  // namespace grtx::explore
