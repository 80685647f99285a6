// Where a sweep's tasks run: processes of this machine, or jobs of a Slurm cluster.
#pragma once

#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "grtx/lab/sweep/own_folder.h"
#include "grtx/lab/sweep/program_run.h"
#include "grtx/lab/sweep/task.h"

namespace grtx::sim {

/// Of a task that left no result of its own.
inline TaskOutcome without_result(const Task& task, const std::string& status, const std::string& reason) {
  TaskOutcome outcome;
  outcome.key = task.key;
  outcome.is_trace = task.is_trace;
  outcome.status = status;
  outcome.reason = reason;
  return outcome;
}

/// The sweep's folder for what is under way: descriptions, results, scratch. All paths absolute.
class WorkFolder {
 public:
  /// Throws Error when something of that name is no sweep's work folder.
  explicit WorkFolder(std::string path) : folder_(std::move(path)) {}
  const std::string& path() const { return folder_.path(); }
  std::string description(const std::string& key) const { return path() + "/tasks/" + key + ".json"; }
  std::string log(const std::string& key) const { return path() + "/tasks/" + key + ".log"; }
  std::string result(const std::string& key) const { return path() + "/results/" + key + ".json"; }
  std::string scratch(const std::string& key) const { return path() + "/scratch/" + key; }
  /// What a task left behind; nothing when there is no result. Of a damaged one: that it must run again.
  std::optional<TaskOutcome> outcome(const Task& task) const;
  /// What ended completely in an earlier, killed sweep. A result that is damaged is none: its task runs again.
  std::vector<TaskOutcome> left_over() const;
  void make() const;
  void remove() const { folder_.remove(); }

 private:
  OwnFolder folder_;
};

class Launcher {
 public:
  virtual ~Launcher() = default;
  /// How many jobs launch() takes now.
  virtual std::size_t free() const = 0;
  /// How many tasks of a job it takes.
  virtual std::size_t most_tasks() const = 0;
  /// The tasks' descriptions are written already.
  virtual void launch(const std::vector<Job>& jobs) = 0;
  /// What has ended since; waits a little when nothing has. Each launched task is reported once.
  virtual std::vector<TaskOutcome> collect() = 0;
};

/// At most `jobs` at a time, each a process of `program`.
class LocalLauncher final : public Launcher {
 public:
  LocalLauncher(const WorkFolder& work, std::string program, unsigned jobs);
  std::size_t free() const override { return jobs_ - running_.size(); }
  std::size_t most_tasks() const override;
  void launch(const std::vector<Job>& jobs) override;
  std::vector<TaskOutcome> collect() override;

 private:
  struct Running {
    std::deque<Task> tasks;  ///< without those that have ended
    std::unique_ptr<ProgramRun> program;
  };
  void start(Running& running) const;

  const WorkFolder& work_;
  std::string program_;
  std::size_t jobs_;
  std::vector<Running> running_;
};

struct SlurmOptions {
  unsigned jobs = 0;                 ///< at a time; 0: as many as the cluster grants
  std::vector<std::string> options;  ///< further words for sbatch: partition, account
  PlanLimits limits;
};

/// One job array at a time, a task each: all tasks that can run, then, when they have ended, the next. An array that a
/// killed sweep left behind is cancelled.
class SlurmLauncher final : public Launcher {
 public:
  /// identity: what tells this sweep's jobs from others', the same when it is resumed. Throws Error when there is no
  /// Slurm.
  SlurmLauncher(const WorkFolder& work, std::string program, const std::string& identity, SlurmOptions options);
  std::size_t free() const override;
  std::size_t most_tasks() const override { return 1; }
  void launch(const std::vector<Job>& jobs) override;
  std::vector<TaskOutcome> collect() override;

 private:
  struct Waiting {
    Task task;
    std::size_t index = 0;  ///< in the array
    unsigned missing = 0;   ///< looks at the queue that did not show it
  };
  void cancel_left_over() const;
  /// Nothing while it is under way.
  std::optional<TaskOutcome> outcome_of(const Waiting& waiting) const;
  void look_at_queue();
  TaskOutcome lost(const Waiting& waiting) const;
  std::string command(const std::vector<std::string>& arguments, int& code) const;

  const WorkFolder& work_;
  std::string program_;
  std::string name_;  ///< of the jobs
  SlurmOptions options_;
  std::string job_;
  std::vector<Waiting> waiting_;
  std::chrono::steady_clock::time_point next_look_;
};

}  // namespace grtx::sim
