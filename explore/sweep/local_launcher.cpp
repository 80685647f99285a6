#include <algorithm>
#include <filesystem>
#include <thread>

#include "grtx/base/error.h"
#include "grtx/explore/sweep/launcher.h"

namespace grtx::sim {
namespace {

namespace fs = std::filesystem;
constexpr auto kBetweenPolls = std::chrono::milliseconds(5);

}  // namespace

std::optional<TaskOutcome> WorkFolder::outcome(const Task& task) const {
  const std::string file = result(task.key);
  if (!fs::exists(file)) return std::nullopt;
  try {
    return read_outcome(file);
  } catch (const Error& error) {
    TaskOutcome damaged;
    damaged.key = task.key;
    damaged.is_trace = task.is_trace;
    damaged.status = task.is_trace ? "failed" : "pending";
    damaged.reason = error.what();
    return damaged;
  }
}

std::vector<TaskOutcome> WorkFolder::left_over() const {
  std::vector<std::string> files;
  if (fs::is_directory(path() + "/results")) {
    for (const auto& entry : fs::directory_iterator(path() + "/results")) {
      if (entry.path().extension() == ".json") files.push_back(entry.path().string());  // others are partial
    }
  }
  std::sort(files.begin(), files.end());
  std::vector<TaskOutcome> outcomes;
  for (const std::string& file : files) {
    try {
      outcomes.push_back(read_outcome(file));
    } catch (const Error&) {  // as if it were not there
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

void LocalLauncher::launch(const std::vector<Task>& tasks) {
  for (const Task& task : tasks) {
    const std::vector<std::string> arguments = {program_,    "sweep",
                                                "--task",    work_.description(task.key),
                                                "--result",  work_.result(task.key),
                                                "--scratch", work_.scratch(task.key)};
    const std::string log = work_.log(task.key);
    running_.push_back({task, std::make_unique<ProgramRun>(arguments, log, log, ProgramLimits{})});
  }
}

std::vector<TaskOutcome> LocalLauncher::collect() {
  std::vector<TaskOutcome> outcomes;
  for (auto running = running_.begin(); running != running_.end();) {
    const auto end = running->program->poll();
    if (!end) {
      ++running;
      continue;
    }
    if (const auto outcome = work_.outcome(running->task)) {
      outcomes.push_back(*outcome);
    } else {
      TaskOutcome lost;
      lost.key = running->task.key;
      lost.is_trace = running->task.is_trace;
      lost.status = end->signal != 0 ? "killed" : "failed";
      lost.reason = end->signal != 0 ? "its process ended by " + signal_name(end->signal)
                                     : "its process ended with exit code " + std::to_string(end->code);
      outcomes.push_back(lost);
    }
    running = running_.erase(running);
  }
  if (outcomes.empty()) std::this_thread::sleep_for(kBetweenPolls);
  return outcomes;
}

}  // namespace grtx::sim
