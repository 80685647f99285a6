// SPDX-License-Identifier: Apache-2.0
// Shared by sweep and search: lock, database, work folder and launcher.
#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "grtx/base/file_lock.h"
#include "grtx/explore/sweep/database.h"
#include "grtx/explore/sweep/launcher.h"
#include "grtx/explore/sweep/sweep.h"

namespace grtx::explore {

/// Version of this program; part of every key.
std::string program_version();

struct SessionOptions {
  std::string database;            ///< path; traces are written to the folder `traces` beside it
  std::string launcher = "local";  ///< or "slurm"
  unsigned jobs = 0;               ///< parallel jobs; 0: one per core, or as many as Slurm grants
  std::string slurm_options;       ///< additional sbatch arguments, separated by spaces
  std::string program;             ///< path of grtx for tracing and simulating; "": this one
  bool retry = false;              ///< also rerun what failed, was killed or timed out
  bool quiet = false;
  std::vector<std::string> modes;  ///< modes to check against `program`
};

class SweepSession {
 public:
  /// Locks and opens the database, records the plan, imports results of a killed session, and creates the launcher.
  /// plan: only limits, machines, path and text are used. Throws Error if the database's folder does not exist, another
  /// sweep uses the database, or a mode is unknown.
  SweepSession(const SessionOptions& options, const SweepPlan& plan);
  /// Keeps the work folder, so that the next session can import complete results.
  ~SweepSession();
  SweepSession(const SweepSession&) = delete;
  SweepSession& operator=(const SweepSession&) = delete;

  /// Adds new points to the database and runs all pending ones. what: label of the progress bar.
  void run(const SweepPoints& points, const std::string& what);
  /// Ends a completed session: removes the work folder.
  void end();

  SweepDatabase& database() { return database_; }
  /// Work of all run() calls so far.
  const TraceWork& trace_work() const { return trace_work_; }

 private:
  std::string path_;  ///< absolute path of the database
  FileLock lock_;
  std::string self_;  ///< path of this program
  WorkFolder work_;
  SweepSetting setting_;
  SweepDatabase database_;
  std::set<std::string> sound_traces_;
  std::unique_ptr<Launcher> launcher_;
  TraceWork trace_work_;
};

}  // namespace grtx::explore
