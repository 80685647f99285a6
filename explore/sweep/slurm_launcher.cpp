// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>
#include <sstream>
#include <thread>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/explore/sweep/launcher.h"

namespace grtx::explore {
namespace {

namespace fs = std::filesystem;
constexpr auto kPause = std::chrono::milliseconds(50);
constexpr auto kBetweenLooks = std::chrono::seconds(1);
constexpr unsigned kLooksUntilLost = 3;  ///< polls; a result may appear shortly after its job leaves the queue
constexpr int kNotFound = 127;
constexpr std::size_t kMaxArray = 1000;  ///< Slurm's default limit of an array (MaxArraySize 1001)

std::string shell_word(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

}  // namespace

SlurmLauncher::SlurmLauncher(const WorkFolder& work, std::string program, const std::string& identity,
                             SlurmOptions options)
    : work_(work),
      program_(std::move(program)),
      name_("grtx-sweep-" + hex(xxh3(identity))),
      options_(std::move(options)) {
  work_.make();
  int code = 0;
  const std::string answer = command({"sinfo", "--version"}, code);
  if (code == kNotFound) throw Error("--launcher", "slurm", "there are no Slurm commands (Debian: slurm-client)");
  if (code != 0) throw Error("--launcher", "slurm", answer);
  cancel_left_over();
}

/// Runs a command; returns its standard output, or its standard error if it fails.
std::string SlurmLauncher::command(const std::vector<std::string>& arguments, int& code) const {
  std::vector<std::string> all = {"/usr/bin/env"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  const std::string output = work_.path() + "/slurm.out", errors = work_.path() + "/slurm.err";
  ProgramLimits limits;
  limits.seconds = 60.0;
  const ProgramEnd end = ProgramRun(all, output, errors, limits).wait();
  code = end.signal != 0 ? -1 : end.code;
  std::string text = read_file(code == 0 ? output : errors);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

void SlurmLauncher::cancel_left_over() const {
  int code = 0;
  if (command({"squeue", "-h", "--name=" + name_, "-o", "%A"}, code).empty() || code != 0) return;
  command({"scancel", "--name=" + name_}, code);
  for (int i = 0; i < 100; ++i) {  // wait until their processes have ended: the folder is cleared next
    if (command({"squeue", "-h", "--name=" + name_, "-o", "%A"}, code).empty()) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

std::size_t SlurmLauncher::free() const { return waiting_.empty() ? kMaxArray : 0; }

void SlurmLauncher::launch(const std::vector<Job>& jobs) {
  if (jobs.empty()) return;
  Job tasks;
  for (const Job& job : jobs) tasks.insert(tasks.end(), job.begin(), job.end());
  std::string list;
  for (const Task& task : tasks) list += task.key + "\n";
  const std::string keys = work_.path() + "/array.keys", script = work_.path() + "/array.sh";
  write_file(keys, list);
  const std::string work = work_.path();
  write_file(script,
             fmt::format("#!/bin/sh\n"
                         "key=$(sed -n \"$((SLURM_ARRAY_TASK_ID + 1))p\" {})\n"
                         "exec {} sweep --task {}/tasks/$key.json --result {}/results/$key.json --scratch "
                         "{}/scratch/$key\n",
                         shell_word(keys), shell_word(program_), shell_word(work), shell_word(work), shell_word(work)));
  // A task runs two commands, each with the limit enforced by us; Slurm's limit is only a backstop.
  const double minutes = std::ceil((2.0 * options_.limits.seconds + 60.0) / 60.0);
  std::vector<std::string> arguments = {
      "sbatch",
      "--parsable",
      "--job-name=" + name_,
      fmt::format("--array=0-{}{}", tasks.size() - 1, options_.jobs == 0 ? "" : fmt::format("%{}", options_.jobs)),
      "--chdir=" + work,
      "--output=" + work + "/log/%a.out",
      fmt::format("--time={:.0f}", minutes),
      fmt::format("--mem={:.0f}M", std::ceil(options_.limits.memory_mb)),
      "--ntasks=1"};
  arguments.insert(arguments.end(), options_.options.begin(), options_.options.end());
  arguments.push_back(script);
  int code = 0;
  const std::string answer = command(arguments, code);
  if (code != 0) throw Error("--launcher", "slurm", answer);
  job_ = answer.substr(0, answer.find(';'));
  for (std::size_t i = 0; i < tasks.size(); ++i) waiting_.push_back({tasks[i], i, 0});
  next_look_ = std::chrono::steady_clock::now() + kBetweenLooks;
}

std::optional<TaskOutcome> SlurmLauncher::outcome_of(const Waiting& waiting) const {
  if (auto left = work_.outcome(waiting.task)) return left;
  if (waiting.missing < kLooksUntilLost) return std::nullopt;
  return lost(waiting);
}

/// Polls the queue and counts for each task the polls in which it was missing.
void SlurmLauncher::look_at_queue() {
  int code = 0;
  const std::string answer = command({"squeue", "-h", "-r", "-j", job_, "-o", "%K"}, code);
  // "Invalid job id": Slurm has already forgotten the job. Other failures are ignored.
  if (code != 0 && answer.find("Invalid job id") == std::string::npos) return;
  std::set<std::size_t> queued;
  if (code == 0) {
    std::istringstream lines(answer);
    for (std::size_t index = 0; lines >> index;) queued.insert(index);
  }
  for (Waiting& waiting : waiting_) {
    if (!queued.contains(waiting.index)) ++waiting.missing;
  }
}

TaskOutcome SlurmLauncher::lost(const Waiting& waiting) const {
  int code = 0;
  const std::string job = command({"scontrol", "show", "job", fmt::format("{}_{}", job_, waiting.index), "-o"}, code);
  std::string state = "unknown";
  if (const std::size_t at = job.find("JobState="); code == 0 && at != std::string::npos) {
    state = job.substr(at + 9, job.find(' ', at) - at - 9);
  }
  return without_result(waiting.task,
                        state == "TIMEOUT"  ? "timeout"
                        : state == "FAILED" ? "failed"
                                            : "killed",
                        fmt::format("Slurm ended its job without a result (state {})", state));
}

std::vector<TaskOutcome> SlurmLauncher::collect() {
  std::vector<TaskOutcome> outcomes;
  if (std::chrono::steady_clock::now() >= next_look_) {
    look_at_queue();
    next_look_ = std::chrono::steady_clock::now() + kBetweenLooks;
  }
  std::erase_if(waiting_, [&](const Waiting& waiting) {
    std::optional<TaskOutcome> outcome = outcome_of(waiting);
    if (outcome) outcomes.push_back(std::move(*outcome));
    return outcome.has_value();
  });
  if (outcomes.empty()) std::this_thread::sleep_for(kPause);
  return outcomes;
}

}  // namespace grtx::explore
