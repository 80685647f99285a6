#include <algorithm>
#include <filesystem>
#include <thread>

#include "grtx/explore/sweep/launcher.h"

namespace grtx::sim {
namespace {

namespace fs = std::filesystem;
constexpr auto kBetweenPolls = std::chrono::milliseconds(5);

}  // namespace

WorkFolder::WorkFolder(std::string path) : path_(std::move(path)) {}

std::vector<TaskOutcome> WorkFolder::left_over() const {
  std::vector<std::string> files;
  if (fs::is_directory(path_ + "/results")) {
    for (const auto& entry : fs::directory_iterator(path_ + "/results")) {
      if (entry.path().extension() == ".json") files.push_back(entry.path().string());  // others are partial
    }
  }
  std::sort(files.begin(), files.end());
  std::vector<TaskOutcome> outcomes;
  for (const std::string& file : files) outcomes.push_back(read_outcome(file));
  return outcomes;
}

void WorkFolder::make() const {
  for (const char* part : {"/tasks", "/results", "/scratch", "/log"}) fs::create_directories(path_ + part);
}

void WorkFolder::remove() const {
  std::error_code ignored;  // a job that Slurm is ending may still write into it
  fs::remove_all(path_, ignored);
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
    const std::string result = work_.result(running->task.key);
    if (fs::exists(result)) {
      outcomes.push_back(read_outcome(result));
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
