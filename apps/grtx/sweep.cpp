// SPDX-License-Identifier: Apache-2.0
// grtx sweep: explores a design space. Runs the points of a plan that the database does not hold yet.
#include "grtx/explore/sweep/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <unordered_set>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/json_output.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/apps/grtx/session_cli.h"
#include "grtx/apps/grtx/trace_requests.h"
#include "grtx/base/error.h"
#include "grtx/base/json.h"
#include "grtx/experiment/machine.h"
#include "grtx/experiment/plan_machine.h"
#include "grtx/experiment/sweep_tracer_rules.h"
#include "grtx/explore/sweep/session.h"
#include "grtx/explore/sweep/stored_points.h"
#include "grtx/report/page/sweep_answer.h"

namespace grtx::apps {
namespace {

namespace fs = std::filesystem;

struct SweepArguments {
  std::string plan;
  explore::SessionOptions session;
  std::string machine = experiment::kDefaultMachine;
  CLI::Option* machine_option = nullptr;
  std::string mode, confirm;
  std::string scene, cameras;
  bool list = false;
  std::vector<std::string> compare;
  std::vector<std::string> task, result;
  std::string scratch;
  bool tracer = false;
};

/// Text on points of the database that are not in its plan; "" if there are none.
std::string earlier_text(const std::string& database, std::size_t points) {
  if (points == 0) return "";
  return fmt::format("{}: {} {} of an earlier plan {} no part", database, points, points == 1 ? "point" : "points",
                     points == 1 ? "takes" : "take");
}

int compare(const SweepArguments& options, const CommonOptions& common) {
  for (const std::string& path : options.compare) {
    if (!fs::exists(path)) throw Error(path, "", "no such file");
  }
  const auto [differences, earlier_plan] = explore::compare_sweeps(options.compare.at(0), options.compare.at(1));
  if (common.json) {
    nlohmann::ordered_json json = json_document("sweep");
    json["differences"] = differences;
    json["earlier_plan"] = earlier_plan;
    print_json(json);
    return differences.empty() ? 0 : 1;
  }
  for (const std::string& line : differences) say("{}", line);
  if (!common.quiet) {
    if (differences.empty()) fmt::print("the same results\n");
    for (std::size_t i = 0; i < earlier_plan.size(); ++i) {
      if (earlier_plan[i] != 0) fmt::print("{}\n", earlier_text(options.compare.at(i), earlier_plan[i]));
    }
  }
  return differences.empty() ? 0 : 1;
}

/// The plan with the overrides of the command line.
explore::SweepPlan plan_of(const SweepArguments& options, const explore::TracerRules& tracer,
                           const CommonOptions& common) {
  explore::SweepPlan plan = explore::load_plan(options.plan, tracer);
  if (!options.mode.empty()) plan.mode = options.mode;
  if (!options.confirm.empty()) plan.confirm = options.confirm;
  const auto asked = options.machine_option->count() > 0 ? std::optional(options.machine) : std::nullopt;
  for (const std::string& file : experiment::put_on_machine(plan, asked)) common.files.check(file);
  if (!options.scene.empty() || !options.cameras.empty()) {
    if (plan.scenes.size() != 1 || !plan.scenes.front().preset.empty()) {
      throw Error("--scene", "", "needs a plan of one scene that is a file");
    }
    if (!options.scene.empty()) plan.scenes.front().file = options.scene;
    if (!options.cameras.empty()) plan.scenes.front().cameras = options.cameras;
  }
  return plan;
}

/// The point as the database would store it.
explore::StoredPoint stored(const explore::SweepPoint& point,
                            const std::shared_ptr<const nlohmann::ordered_json>& trace) {
  explore::StoredPoint stored;
  stored.key = point.key;
  stored.machine = point.machine;
  stored.mode = point.mode;
  stored.scene = point.scene;
  stored.design = point.design;
  stored.coordinates = point.coordinates;
  stored.config = point.config.json();
  stored.trace = trace;
  return stored;
}

/// The points of a plan, and points of its database that are not in the plan.
class PointList {
 public:
  PointList(const explore::SweepPoints& all, const std::string& database) : all_(all), statuses_(all.points.size()) {
    if (!fs::exists(database)) return;
    explore::SweepDatabase opened(database);
    statuses_ = opened.statuses_of(all.points);
    std::unordered_set<std::string> asked;
    for (const std::string& mode : opened.modes()) {
      for (const explore::SweepPoint& point : all.points)
        asked.insert(explore::key_in_mode(point, mode, explore::program_version()));
    }
    explore::Sqlite reader(database, explore::Sqlite::Open::read_only);
    earlier_ = explore::read_points(reader, [&](const std::string& key) { return !asked.contains(key); });
    if (!earlier_.empty()) tell_apart_from_earlier();
  }

  void print(bool as_json) const {
    std::optional<JsonListPrinter> list;
    if (as_json) list.emplace(json_document("sweep"), "points");
    const auto print = [&](const auto& point, const std::string& status, const auto& coordinates, bool earlier_plan) {
      const nlohmann::ordered_json varied = earlier_plan ? nlohmann::ordered_json() : point.coordinates;
      if (list) {
        list->add({{"key", point.key},
                   {"status", status},
                   {"machine", point.machine},
                   {"mode", point.mode},
                   {"scene", point.scene},
                   {"design", point.design},
                   {"coordinates", coordinates},
                   {"varied", varied},
                   {"earlier_plan", earlier_plan}});
      } else {
        fmt::print("{} {:<8} {}{}{} {} {}{}\n    {}\n", point.key, status, point.machine,
                   point.machine.empty() ? "" : " ", point.mode, point.scene, point.design,
                   earlier_plan ? " (of an earlier plan)" : "", json_text(coordinates));
      }
    };
    for (std::size_t i = 0; i < statuses_.size(); ++i) {
      const explore::SweepPoint& point = all_.points[i];
      print(point, statuses_[i].empty() ? "new" : statuses_[i],
            told_.empty() ? point.coordinates : told_[i].coordinates, false);
    }
    for (const explore::StoredPoint& point : earlier_) print(point, point.status, point.coordinates, true);
    if (list) {
      list->end({{"traces", all_.traces.size()}});
      return;
    }
    fmt::print("{} points, {} traces{}\n", all_.points.size(), all_.traces.size(),
               earlier_.empty() ? "" : fmt::format("; {} of an earlier plan", earlier_.size()));
  }

 private:
  void tell_apart_from_earlier() {
    std::map<std::string, std::shared_ptr<const nlohmann::ordered_json>> traces;
    for (const auto& trace : all_.traces) {
      traces[trace->key] = std::make_shared<const nlohmann::ordered_json>(explore::trace_inputs(trace->options));
    }
    for (const explore::SweepPoint& point : all_.points) told_.push_back(stored(point, traces.at(point.trace_key)));
    std::vector<explore::StoredPoint*> points;
    for (explore::StoredPoint& point : told_) points.push_back(&point);
    for (explore::StoredPoint& point : earlier_) points.push_back(&point);
    explore::add_distinguishing_inputs(points);
  }

  const explore::SweepPoints& all_;
  std::vector<std::string> statuses_;       ///< one per point; "" for a new one
  std::vector<explore::StoredPoint> told_;  ///< points of all_; only filled if there are earlier ones
  std::vector<explore::StoredPoint> earlier_;
};

/// The most frequent reason, and how many others there are.
std::string reason_text(const std::map<std::string, std::size_t>& reasons) {
  if (reasons.empty()) return "";
  const auto most = std::ranges::max_element(reasons, {}, [](const auto& reason) { return reason.second; });
  return fmt::format(": {}{}", most->first,
                     reasons.size() == 1 ? "" : fmt::format(" (and {} other reasons)", reasons.size() - 1));
}

int print_summary(const std::vector<explore::SweepPoint>& points, explore::SweepDatabase& database,
                  const explore::TraceWork& work, const std::string& path, const CommonOptions& common) {
  const std::map<std::string, std::size_t> counts = database.summary(points);
  std::string text;
  for (const auto& [status, count] : counts) text += fmt::format("{} {} {}", text.empty() ? ":" : ",", count, status);
  if (common.json) {
    nlohmann::ordered_json json = json_document("sweep");
    json["database"] = path;
    json["points"] = points.size();
    json["status"] = counts;
    json["earlier_plan"] = database.earlier_points();
    json["traces_made"] = work.made;
    json["structures_built"] = work.structures_built;
    print_json(json);
  } else if (!common.quiet) {
    fmt::print("{} points{}; {}\n", points.size(), text, path);
    if (work.made != 0) fmt::print("{}\n", describe(work));
    if (const std::size_t earlier = database.earlier_points(); earlier != 0) {
      fmt::print("{}\n", earlier_text(path, earlier));
    }
    fmt::print("{}{}\n", report::sweep_answer_text(report::read_sweep_results(path)), next_report(path));
  }
  const auto done = counts.find("done");
  const std::size_t missing = points.size() - (done == counts.end() ? 0 : done->second);
  if (missing == 0) return 0;
  if (common.json || !common.quiet) std::fflush(stdout);
  fmt::print(stderr, "grtx: sweep: {} of {} points have no result{}\n", missing, points.size(),
             reason_text(database.reasons(points)));
  return 1;
}

int sweep(const SweepArguments& options, const CommonOptions& common) {
  const bool quiet = common.quiet;
  if (!options.task.empty()) {
    explore::run_tasks(options.task, options.result, options.scratch);
    return 0;
  }
  if (options.tracer) return answer_trace_requests(std::cin, stdout);
  if (!options.compare.empty()) return compare(options, common);
  if (options.plan.empty()) throw Error("sweep", "PLAN", "a plan is needed");
  const experiment::SceneTracerRules tracer;
  const explore::SweepPlan plan = plan_of(options, tracer, common);
  explore::SweepPoints all = explore::expand(plan, tracer, explore::program_version());
  if (options.list) {
    PointList(all, options.session.database).print(common.json);
    return 0;
  }
  if (options.session.database.empty()) throw Error("sweep", "-o", "a database is needed");
  explore::SessionOptions with = options.session;
  with.quiet = quiet;
  with.modes = {plan.mode};
  if (!plan.confirm.empty()) with.modes.push_back(plan.confirm);
  explore::SweepSession session(with, plan);
  session.run(all, "sweep");
  if (!plan.confirm.empty() && plan.confirm != plan.mode) {
    explore::SweepPoints front;
    front.traces = all.traces;
    for (const explore::SweepPoint& point : explore::pareto_front(all.points, session.database(), plan.area)) {
      front.points.push_back(explore::in_mode(point, plan.confirm, explore::program_version()));
    }
    if (!quiet) fmt::print(stderr, "confirming {} points of the front with {}\n", front.points.size(), plan.confirm);
    session.run(front, "sweep");
    all.points.insert(all.points.end(), front.points.begin(), front.points.end());
  }
  session.end();
  return print_summary(all.points, session.database(), session.trace_work(), options.session.database, common);
}

}  // namespace

void add_sweep(CLI::App& app, CommonOptions& common) {
  const auto options = std::make_shared<SweepArguments>();
  CLI::App* command = make_command(app, common, "sweep", "Explores a design space; results in an SQLite database",
                                   [options, &common] { return sweep(*options, common); });
  command->add_option("PLAN", options->plan, "Plan in TOML, docs/guide/sweep.md (no default)")->type_name(kInputFile);
  add_session_options(command, options->session);
  options->machine_option = add_machine_option(command, options->machine)->default_str("the plan's, else paper");
  command->add_option("--mode", options->mode, "Mode of grtx sim (default: the plan's, else cycle)");
  command->add_option(
      "--confirm", options->confirm,
      "Mode in which the front of time against area is simulated again (default: the plan's, else none)");
  command->add_option("--scene", options->scene, "Scene file in place of the plan's only one (default: the plan's)")
      ->type_name(kInputFile);
  command->add_option("--cameras", options->cameras, "Camera file in place of the plan's (default: the plan's)")
      ->type_name(kInputFile);
  command->add_flag("--list", options->list,
                    "Print the plan's points, then what else -o holds, and do nothing (default: off)");
  command
      ->add_option("--compare", options->compare,
                   "Two databases: prints what differs between the points of their plans, exit 1 (default: none)")
      ->expected(2);
  // Hidden options by which a sweep runs its tasks.
  command->add_option("--task", options->task)->group("");
  command->add_option("--result", options->result)->group("");
  command->add_option("--scratch", options->scratch)->group("");
  command->add_flag("--tracer", options->tracer)->group("");
}

}  // namespace grtx::apps
