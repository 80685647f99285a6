// grtx sweep: explores a design space. Runs the points of a plan that the database does not hold yet.
#include "grtx/explore/sweep/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <sstream>
#include <thread>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/machine.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/apps/grtx/sweep_tracer_rules.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"

namespace grtx::sim {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string plan;
  std::string output;
  std::string machine;
  std::string mode, confirm;
  std::string scene, cameras;
  std::string launcher = "local";
  unsigned jobs = 0;
  std::string slurm_options;
  std::string program;
  bool retry = false;
  bool list = false;
  std::vector<std::string> compare;
  std::string task, result, scratch;
};

const std::string kProgramVersion = std::string("grtx ") + GRTX_VERSION;

std::string this_program() { return fs::read_symlink("/proc/self/exe").string(); }

int compare(const Options& options, bool quiet) {
  for (const std::string& path : options.compare) {
    if (!fs::exists(path)) throw Error(path, "", "no such file");
  }
  const std::vector<std::string> differences = compare_sweeps(options.compare.at(0), options.compare.at(1));
  for (const std::string& line : differences) fmt::print("{}\n", line);
  if (!quiet && differences.empty()) fmt::print("the same results\n");
  return differences.empty() ? 0 : 1;
}

/// The plan with what the command line overrides.
SweepPlan plan_of(const Options& options, const TracerRules& tracer) {
  SweepPlan plan = load_plan(options.plan, tracer);
  if (!options.mode.empty()) plan.mode = options.mode;
  if (!options.confirm.empty()) plan.confirm = options.confirm;
  if (!options.machine.empty()) {  // below whatever the plan says
    plan.machine = load_machine_config(options.machine, plan.base, {});
    Coordinates settings;
    for (const auto& [name, value] : machine_tracer(options.machine)) settings.emplace_back("tracer." + name, value);
    plan.settings.insert(plan.settings.begin(), settings.begin(), settings.end());
  }
  if (!options.scene.empty() || !options.cameras.empty()) {
    if (plan.scenes.size() != 1 || !plan.scenes.front().preset.empty()) {
      throw Error("--scene", "", "needs a plan of one scene that is a file");
    }
    if (!options.scene.empty()) plan.scenes.front().file = options.scene;
    if (!options.cameras.empty()) plan.scenes.front().cameras = options.cameras;
  }
  return plan;
}

/// Asks `grtx sim` whether it knows a mode, so that a mistyped one is no failure of every point. errors: a file for
/// what it says.
void check_mode(const std::string& mode, const std::string& program, const std::string& errors,
                const std::string& plan) {
  ProgramLimits limits;
  limits.seconds = 60.0;
  const ProgramEnd end =
      ProgramRun({program, "sim", "--mode", mode, "--list-config"}, "/dev/null", errors, limits).wait();
  std::string reason = read_file(errors);
  fs::remove(errors);
  if (end.code != 2 || end.signal != 0) return;
  while (!reason.empty() && reason.back() == '\n') reason.pop_back();
  throw Error(plan, "mode", reason.starts_with("grtx: ") ? reason.substr(6) : reason);
}

void list_points(const SweepPoints& all, const std::string& database_path) {
  std::unique_ptr<SweepDatabase> database;
  if (fs::exists(database_path)) database = std::make_unique<SweepDatabase>(database_path);
  for (const SweepPoint& point : all.points) {
    std::string status = database ? database->status_of_point(point.key) : "";
    fmt::print("{} {:<8} {} {} {} {}\n", point.key, status.empty() ? "new" : status, point.mode, point.scene,
               point.design, point.coordinates.dump());
  }
  fmt::print("{} points, {} traces\n", all.points.size(), all.traces.size());
}

std::vector<std::string> words(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> list;
  for (std::string word; stream >> word;) list.push_back(word);
  return list;
}

int print_summary(const std::vector<SweepPoint>& points, SweepDatabase& database, const Options& options, bool quiet) {
  const std::map<std::string, std::size_t> counts = database.summary(points);
  std::string text;
  for (const auto& [status, count] : counts) text += fmt::format("{} {} {}", text.empty() ? ":" : ",", count, status);
  if (!quiet) fmt::print("{} points{}; {}\n", points.size(), text, options.output);
  const auto done = counts.find("done");
  return done != counts.end() && done->second == points.size() ? 0 : 1;
}

int sweep(const Options& options, bool quiet) {
  if (!options.task.empty()) {
    run_task(options.task, options.result, options.scratch);
    return 0;
  }
  if (!options.compare.empty()) return compare(options, quiet);
  if (options.plan.empty()) throw Error("sweep", "PLAN", "a plan is needed");
  const CliTracerRules tracer;
  const SweepPlan plan = plan_of(options, tracer);
  SweepPoints all = expand(plan, tracer, kProgramVersion);
  if (options.list) {
    list_points(all, options.output);
    return 0;
  }
  if (options.output.empty()) throw Error("sweep", "-o", "a database is needed");

  const std::string path = fs::absolute(options.output).lexically_normal().string();
  const std::string folder = fs::path(path).parent_path().string();
  if (!fs::is_directory(folder)) throw Error(options.output, "", "there is no folder " + folder);
  const SweepLock lock(path);
  const std::string self = this_program();
  const std::string program = options.program.empty() ? self : fs::absolute(options.program).string();
  check_mode(plan.mode, program, path + ".mode", options.plan);
  if (!plan.confirm.empty()) check_mode(plan.confirm, program, path + ".mode", options.plan);
  SweepDatabase database(path);
  const std::string build = hex(xxh3(read_file(self)));
  if (const std::string before = database.meta("build"); !quiet && !before.empty() && before != build) {
    fmt::print(stderr, "grtx: sweep: {} was begun by another build of {}; its points are kept\n", options.output,
               kProgramVersion);
  }
  const WorkFolder work(path + ".work");
  const std::vector<TaskOutcome> left_over = work.left_over();
  database.begin(plan, all, kProgramVersion, build, options.retry);
  for (const TaskOutcome& outcome : left_over) {
    const std::string status =
        outcome.is_trace ? database.status_of_trace(outcome.key) : database.status_of_point(outcome.key);
    if (status == "pending") database.record(outcome);
  }
  const SweepSetting setting = {program, folder + "/traces", plan.limits, quiet};
  fs::create_directories(setting.traces);
  work.make();
  std::unique_ptr<Launcher> launcher;
  if (options.launcher == "slurm") {
    launcher = std::make_unique<SlurmLauncher>(work, self, path,
                                               SlurmOptions{options.jobs, words(options.slurm_options), plan.limits});
  } else {
    const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
    launcher = std::make_unique<LocalLauncher>(work, self, options.jobs == 0 ? cores : options.jobs);
  }
  work.remove();  // Slurm's jobs of a killed sweep have ended now
  work.make();

  run_points(all, database, *launcher, work, setting);
  if (!plan.confirm.empty() && plan.confirm != plan.mode) {
    SweepPoints front;
    front.traces = all.traces;
    for (const SweepPoint& point : pareto_front(all.points, database)) {
      front.points.push_back(in_mode(point, plan.confirm, kProgramVersion));
    }
    if (!quiet) fmt::print(stderr, "confirming {} points of the front with {}\n", front.points.size(), plan.confirm);
    database.add(front.points);
    run_points(front, database, *launcher, work, setting);
    all.points.insert(all.points.end(), front.points.begin(), front.points.end());
  }
  launcher.reset();
  work.remove();
  return print_summary(all.points, database, options, quiet);
}

}  // namespace

void add_sweep(CLI::App& app, CommonOptions& common) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = make_command(app, common, "sweep", "Explores a design space; results in an SQLite database",
                                   [options, &common] { return sweep(*options, common.quiet); });
  command->add_option("PLAN", options->plan, "Plan in TOML, docs/guide/sweep.md (no default)");
  command->add_option("-o,--output", options->output,
                      "Database to fill; points that it holds are not run again; traces go to the folder traces beside "
                      "it (no default)");
  add_machine_option(command, options->machine);
  command->add_option("--mode", options->mode, "Mode of grtx sim (default: the plan's, else cycle)");
  command->add_option(
      "--confirm", options->confirm,
      "Mode in which the front of time against area is simulated again (default: the plan's, else none)");
  command->add_option("--scene", options->scene, "Scene file in place of the plan's only one (default: the plan's)");
  command->add_option("--cameras", options->cameras, "Camera file in place of the plan's (default: the plan's)");
  command->add_option("--launcher", options->launcher, "Processes of this machine, or a job array of Slurm")
      ->check(one_of({"local", "slurm"}));
  command->add_option("--jobs", options->jobs, "Points at a time; 0: one a core, or as many as Slurm grants");
  command->add_option("--sbatch", options->slurm_options,
                      "Further options for sbatch, in one text: \"-p long -A project\" (default: none)");
  command->add_option("--program", options->program, "The grtx that traces and simulates (default: this one)");
  command->add_flag("--retry", options->retry,
                    "Run points again that failed, were killed or took too long (default: off)");
  command->add_flag("--list", options->list, "Print the plan's points and do nothing (default: off)");
  command->add_option("--compare", options->compare, "Two databases: prints what differs, exit 1 (default: none)")
      ->expected(2);
  // How a sweep runs its tasks; for no one else.
  command->add_option("--task", options->task)->group("");
  command->add_option("--result", options->result)->group("");
  command->add_option("--scratch", options->scratch)->group("");
}

}  // namespace grtx::sim
