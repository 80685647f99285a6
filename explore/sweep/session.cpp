// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/sweep/session.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <thread>

#include "grtx/base/atomic_file.h"
#include "grtx/base/end_by_signal.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/explore/sweep/program_run.h"
#include "grtx/rtl_tlm/run/model_version.h"

namespace grtx::explore {
namespace {

namespace fs = std::filesystem;

std::string this_program() { return fs::read_symlink("/proc/self/exe").string(); }

/// The database's absolute path.
std::string database_path(const std::string& given) {
  const std::string path = fs::absolute(given).lexically_normal().string();
  const std::string folder = fs::path(path).parent_path().string();
  if (!fs::is_directory(folder)) throw Error(given, "", "there is no folder " + folder);
  return path;
}

/// Creates an empty temporary file with a unique name.
std::string temporary_file() {
  std::string path = (fs::temp_directory_path() / "grtx-XXXXXX").string();
  const int file = ::mkstemp(path.data());
  if (file < 0) throw Error(path, "", std::string("cannot be made: ") + std::strerror(errno));
  ::close(file);
  return path;
}

/// Checks with `grtx sim` that a mode exists, so that a mistyped one does not make every point fail.
void check_mode(const std::string& mode, const std::string& program, const std::string& plan) {
  const std::string errors = temporary_file();
  const RemovedBySignal temporary(errors);
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

SweepSetting setting_of(const SessionOptions& options, const SweepPlan& plan, const std::string& path,
                        const std::string& self) {
  const std::string program = options.program.empty() ? self : fs::absolute(options.program).string();
  for (const std::string& mode : options.modes) check_mode(mode, program, plan.path);
  return {program, fs::path(path).parent_path().string() + "/traces", plan.limits, options.quiet};
}

std::vector<std::string> words(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> list;
  for (std::string word; stream >> word;) list.push_back(word);
  return list;
}

}  // namespace

std::string program_version() { return std::string("grtx ") + GRTX_VERSION; }

SweepSession::SweepSession(const SessionOptions& options, const SweepPlan& plan)
    : path_(database_path(options.database)),
      lock_(path_ + ".lock", path_, "another sweep is filling it"),
      self_(this_program()),
      work_(path_ + ".work"),
      setting_(setting_of(options, plan, path_, self_)),
      database_(path_) {
  const std::string build = hex(xxh3(read_file(self_)));
  if (const std::string before = database_.meta("build"); !options.quiet && !before.empty() && before != build) {
    fmt::print(stderr, "grtx: sweep: {} was begun by another build of {}; its points are kept\n", options.database,
               program_version());
  }
  // Keys of points do not contain the model version: without this check, points of two models would be mixed.
  const std::string version = std::to_string(sim::kModelVersion);
  if (const std::string before = database_.meta("model_version"); before.empty()) {
    database_.set_meta("model_version", version);
  } else if (before != version) {
    throw Error(path_, "meta.model_version",
                fmt::format("{}: this program's model has version {}: begin another database", before, version));
  }
  const std::vector<TaskOutcome> left_over = work_.left_over();
  database_.begin(plan, program_version(), build, options.retry);
  for (const TaskOutcome& outcome : left_over) {
    const std::string status =
        outcome.is_trace ? database_.status_of_trace(outcome.key) : database_.status_of_point(outcome.key);
    if (status == "pending") database_.record(outcome);
  }
  fs::create_directories(setting_.traces);
  work_.make();
  if (options.launcher == "slurm") {
    launcher_ = std::make_unique<SlurmLauncher>(work_, self_, path_,
                                                SlurmOptions{options.jobs, words(options.slurm_options), plan.limits});
  } else {
    const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
    launcher_ = std::make_unique<LocalLauncher>(work_, self_, options.jobs == 0 ? cores : options.jobs);
  }
  work_.remove();  // safe now: the launcher cancelled Slurm jobs of a killed sweep
  work_.make();
}

SweepSession::~SweepSession() = default;

void SweepSession::run(const SweepPoints& points, const std::string& what) {
  say_when_ended_by_signal("; start again to resume");
  database_.add(points);
  setting_.what = what;
  trace_work_.add(run_points(points, database_, *launcher_, work_, setting_, sound_traces_));
}

void SweepSession::end() {
  launcher_.reset();
  work_.remove();
  std::error_code not_empty;
  fs::remove(setting_.traces, not_empty);  // of a sweep that traced nothing
}

}  // namespace grtx::explore
