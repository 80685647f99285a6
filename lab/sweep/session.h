// What a sweep and a search do around their points: lock, database, work folder, launcher.
#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "grtx/base/file_lock.h"
#include "grtx/lab/sweep/database.h"
#include "grtx/lab/sweep/launcher.h"
#include "grtx/lab/sweep/sweep.h"

namespace grtx::sim {

/// Version of the program that makes points: part of every key.
std::string program_version();

struct SessionOptions {
  std::string database;            ///< to fill; traces go to the folder traces beside it
  std::string launcher = "local";  ///< or "slurm"
  unsigned jobs = 0;               ///< points at a time; 0: one a core, or as many as Slurm grants
  std::string slurm_options;       ///< further words for sbatch, in one text
  std::string program;             ///< the grtx that traces and simulates; "": this one
  bool retry = false;              ///< also what failed, was killed or took too long
  bool quiet = false;
  std::vector<std::string> modes;  ///< that grtx sim must know
};

class SweepSession {
 public:
  /// Locks and opens the database, notes the plan, takes in what a killed session left, and makes the launcher. plan:
  /// of which limits, machine, path and text are used. Throws Error when there is no folder for the database, another
  /// sweep is filling it, or a mode is unknown.
  SweepSession(const SessionOptions& options, const SweepPlan& plan);
  /// Leaves the work folder, for the next session to take in what is complete.
  ~SweepSession();
  SweepSession(const SweepSession&) = delete;
  SweepSession& operator=(const SweepSession&) = delete;

  /// Adds what the database does not hold, and runs what is pending. what: for the progress.
  void run(const SweepPoints& points, const std::string& what);
  /// All is done: removes the work folder.
  void end();

  SweepDatabase& database() { return database_; }
  /// For all runs so far.
  const TraceWork& trace_work() const { return trace_work_; }

 private:
  std::string path_;  ///< of the database, absolute
  FileLock lock_;
  std::string self_;  ///< this program
  WorkFolder work_;
  SweepSetting setting_;
  SweepDatabase database_;
  std::set<std::string> sound_traces_;
  std::unique_ptr<Launcher> launcher_;
  TraceWork trace_work_;
};

}  // namespace grtx::sim
