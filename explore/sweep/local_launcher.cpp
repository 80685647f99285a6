// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <thread>

#include "grtx/base/error.h"
#include "grtx/explore/sweep/launcher.h"

namespace grtx::explore {
namespace {

namespace fs = std::filesystem;
constexpr auto kBetweenPolls = std::chrono::milliseconds(5);
constexpr std::size_t kMostTasks = 500;  ///< each adds two paths to the command line, whose length is limited

/// Outcome of a task whose process ended without a result.
TaskOutcome lost(const Task& task, const ProgramEnd& end) {
  if (end.signal != 0) return without_result(task, "killed", "its process ended by " + signal_name(end.signal));
  return without_result(task, "failed", "its process ended with exit code " + std::to_string(end.code));
}

}  // namespace

std::optional<TaskOutcome> WorkFolder::outcome(const Task& task) const {
  const std::string file = result(task.key);
  if (!fs::exists(file)) return std::nullopt;
  try {
    return read_outcome(file);
  } catch (const Error& error) {
    return without_result(task, task.is_trace ? "failed" : "pending", error.what());
  }
}

std::vector<TaskOutcome> WorkFolder::left_over() const {
  std::vector<std::string> files;
  if (fs::is_directory(path() + "/results")) {
    for (const auto& entry : fs::directory_iterator(path() + "/results")) {
      if (entry.path().extension() == ".json") files.push_back(entry.path().string());  // others are incomplete
    }
  }
  std::sort(files.begin(), files.end());
  std::vector<TaskOutcome> outcomes;
  for (const std::string& file : files) {
    try {
      outcomes.push_back(read_outcome(file));
    } catch (const Error&) {  // damaged: ignored
    }
  }
  return outcomes;
}

void WorkFolder::make() const {
  folder_.make();
  for (const char* part : {"/tasks", "/results", "/scratch", "/log"}) fs::create_directories(path() + part);
}

LocalLauncher::LocalLauncher(const WorkFolder& work, std::string program, unsigned jobs)
    : work_(work), program_(std::move(program)), jobs_(std::max(1U, jobs)) {}

std::size_t LocalLauncher::most_tasks() const { return kMostTasks; }

void LocalLauncher::start(Running& running) const {
  const std::string& first = running.tasks.front().key;
  std::vector<std::string> arguments = {program_, "sweep", "--scratch", work_.scratch(first)};
  for (const Task& task : running.tasks) {
    arguments.insert(arguments.end(), {"--task", work_.description(task.key), "--result", work_.result(task.key)});
  }
  const std::string log = work_.log(first);
  running.program = std::make_unique<ProgramRun>(arguments, log, log, ProgramLimits{});
}

void LocalLauncher::launch(const std::vector<Job>& jobs) {
  for (const Job& job : jobs) {
    Running running{{job.begin(), job.end()}, nullptr};
    start(running);
    running_.push_back(std::move(running));
  }
}

std::vector<TaskOutcome> LocalLauncher::collect() {
  std::vector<TaskOutcome> outcomes;
  for (auto running = running_.begin(); running != running_.end();) {
    std::deque<Task>& tasks = running->tasks;
    const auto end = running->program->poll();  // before reading results, so that a last one is not missed
    while (tasks.size() > (end ? 0 : 1)) {      // the last task stays until the process has ended
      const auto outcome = work_.outcome(tasks.front());
      if (!outcome) break;
      outcomes.push_back(*outcome);
      tasks.pop_front();
    }
    if (end && !tasks.empty()) {  // ended during a task: run the others in a new process
      outcomes.push_back(lost(tasks.front(), *end));
      tasks.pop_front();
      if (!tasks.empty()) start(*running);
    }
    running = end && tasks.empty() ? running_.erase(running) : std::next(running);
  }
  if (outcomes.empty()) std::this_thread::sleep_for(kBetweenPolls);
  return outcomes;
}

}  // namespace grtx::explore
