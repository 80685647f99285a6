// SPDX-License-Identifier: Apache-2.0
// Runs a sweep's tasks as local processes or as jobs of a Slurm cluster.
#pragma once

#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "grtx/explore/sweep/marked_folder.h"
#include "grtx/explore/sweep/program_run.h"
#include "grtx/explore/sweep/task.h"

namespace grtx::explore {

/// Outcome of a task that wrote no valid result.
inline TaskOutcome without_result(const Task& task, const std::string& status, const std::string& reason) {
  TaskOutcome outcome;
  outcome.key = task.key;
  outcome.is_trace = task.is_trace;
  outcome.status = status;
  outcome.reason = reason;
  return outcome;
}

/// A sweep's folder for running tasks: descriptions, results, scratch. All paths are absolute.
class WorkFolder {
 public:
  /// Throws Error if the path exists and is no work folder of a sweep.
  explicit WorkFolder(std::string path) : folder_(std::move(path)) {}
  const std::string& path() const { return folder_.path(); }
  std::string description(const std::string& key) const { return path() + "/tasks/" + key + ".json"; }
  std::string log(const std::string& key) const { return path() + "/tasks/" + key + ".log"; }
  std::string result(const std::string& key) const { return path() + "/results/" + key + ".json"; }
  std::string scratch(const std::string& key) const { return path() + "/scratch/" + key; }
  /// Result of a task; nullopt if there is none yet. A damaged result gives status "pending" for a point and "failed"
  /// for a trace.
  std::optional<TaskOutcome> outcome(const Task& task) const;
  /// Complete results left by a killed sweep. Damaged ones are ignored, so their tasks run again.
  std::vector<TaskOutcome> left_over() const;
  void make() const;
  void remove() const { folder_.remove(); }

 private:
  MarkedFolder folder_;
};

class Launcher {
 public:
  virtual ~Launcher() = default;
  /// Number of jobs that launch() accepts now.
  virtual std::size_t free() const = 0;
  /// Maximum number of tasks per job.
  virtual std::size_t most_tasks() const = 0;
  /// Starts jobs; at most free(). The descriptions of their tasks must have been written.
  virtual void launch(const std::vector<Job>& jobs) = 0;
  /// Outcomes of tasks that ended since the last call; waits briefly if there are none. Each launched task is reported
  /// once.
  virtual std::vector<TaskOutcome> collect() = 0;
};

/// Runs at most `jobs` jobs in parallel, each a process of `program`.
class LocalLauncher final : public Launcher {
 public:
  LocalLauncher(const WorkFolder& work, std::string program, unsigned jobs);
  std::size_t free() const override { return jobs_ - running_.size(); }
  std::size_t most_tasks() const override;
  void launch(const std::vector<Job>& jobs) override;
  std::vector<TaskOutcome> collect() override;

 private:
  struct Running {
    std::deque<Task> tasks;  ///< not yet ended; the front runs
    std::unique_ptr<ProgramRun> program;
  };
  void start(Running& running) const;

  const WorkFolder& work_;
  std::string program_;
  std::size_t jobs_;
  std::vector<Running> running_;
};

struct SlurmOptions {
  unsigned jobs = 0;                 ///< parallel jobs; 0: as many as the cluster grants
  std::vector<std::string> options;  ///< additional sbatch arguments: partition, account
  PlanLimits limits;
};

/// Runs one job array at a time, one task per job: launches all ready tasks, and the next array when they have ended.
/// Cancels an array left by a killed sweep.
class SlurmLauncher final : public Launcher {
 public:
  /// identity: names this sweep's jobs; must be the same when the sweep is resumed. Throws Error if Slurm is not
  /// available.
  SlurmLauncher(const WorkFolder& work, std::string program, const std::string& identity, SlurmOptions options);
  std::size_t free() const override;
  std::size_t most_tasks() const override { return 1; }
  void launch(const std::vector<Job>& jobs) override;
  std::vector<TaskOutcome> collect() override;

 private:
  struct Waiting {
    Task task;
    std::size_t index = 0;  ///< index in the job array
    unsigned missing = 0;   ///< number of queue polls in which it was missing
  };
  void cancel_left_over() const;
  /// nullopt while it runs.
  std::optional<TaskOutcome> outcome_of(const Waiting& waiting) const;
  void look_at_queue();
  TaskOutcome lost(const Waiting& waiting) const;
  std::string command(const std::vector<std::string>& arguments, int& code) const;

  const WorkFolder& work_;
  std::string program_;
  std::string name_;  ///< job name
  SlurmOptions options_;
  std::string job_;
  std::vector<Waiting> waiting_;
  std::chrono::steady_clock::time_point next_look_;
};

}  // namespace grtx::explore
