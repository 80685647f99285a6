// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/sweep/task.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/files_read.h"
#include "grtx/base/json.h"
#include "grtx/explore/cost/run_machine.h"
#include "grtx/explore/sweep/database.h"
#include "grtx/explore/sweep/marked_folder.h"
#include "grtx/explore/sweep/program_run.h"
#include "grtx/explore/sweep/tracer_process.h"
#include "grtx/rtl_tlm/run/statistics_json.h"
#include "grtx/traces/reader.h"

namespace grtx::explore {
namespace {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

/// Thrown if a command of a task fails.
struct Failure {
  std::string status, reason;
};

/// The last line that a command wrote to standard error: its error message.
std::string last_line(const std::string& path) {
  std::string text = fs::exists(path) ? read_file(path) : "";
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::string line = text.substr(text.rfind('\n') + 1);
  if (line.starts_with("grtx: ")) line = line.substr(6);
  return line.substr(0, 1000);
}

ProgramLimits limits_of(const ordered_json& task) {
  const ordered_json& limits = task.at("limits");
  return {limits.at("seconds").get<double>(), static_cast<std::uint64_t>(limits.at("memory_mb").get<double>() * 1e6)};
}

/// Runs the commands of one task in its scratch folder.
class Commands {
 public:
  Commands(const ordered_json& task, std::string scratch)
      : task_(task), scratch_(std::move(scratch)), limits_(limits_of(task)) {}

  std::string file(const std::string& name) const { return scratch_ + "/" + name; }

  Failure too_long(const std::string& name) const {
    return {"timeout", fmt::format("{}: longer than {} s", name, limits_.seconds)};
  }

  /// Runs a grtx command; returns wall seconds. Standard output goes to file(`name` + ".out"). Throws Failure.
  double run(const std::string& name, const std::vector<std::string>& arguments) const {
    std::vector<std::string> all = {task_.at("program").get<std::string>(), name};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const std::string errors = file(name + ".err");
    ProgramRun program(all, file(name + ".out"), errors, limits_);
    const ProgramEnd end = program.wait();
    if (end.timeout) throw too_long(name);
    if (end.signal != 0) throw Failure{"killed", fmt::format("{}: ended by {}", name, signal_name(end.signal))};
    if (end.code != 0) {
      const std::string line = last_line(errors);
      throw Failure{"failed", fmt::format("{}: {}", name, line.empty() ? fmt::format("exit code {}", end.code) : line)};
    }
    return end.seconds;
  }

 private:
  const ordered_json& task_;
  std::string scratch_;
  ProgramLimits limits_;
};

/// Scratch folder of a process: emptied at the start, removed at the end.
class Scratch {
 public:
  explicit Scratch(const std::string& path) : folder_(path) {
    folder_.remove();
    folder_.make();
  }
  ~Scratch() { folder_.remove(); }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

 private:
  const MarkedFolder folder_;
};

std::vector<std::string> texts(const ordered_json& list) { return list.get<std::vector<std::string>>(); }

/// Whether a trace file exists and its content hash matches: a power loss may leave a file of zeros.
bool is_intact(const std::string& trace) {
  try {
    traces::Reader(trace).verify_content();
    return true;
  } catch (const Error&) {
    return false;
  }
}

/// Why a trace does not match the inputs of its key; "" if it does. files: expected FilesRead::hash().
std::string mismatch(const std::string& trace, const std::string& files, const ordered_json& tracer) {
  const traces::Reader reader(trace);
  reader.verify_content();
  const auto& inputs = reader.header().inputs;
  const auto input_of = [&](const std::string& name) { return inputs.contains(name) ? inputs.at(name) : "unknown"; };
  if (input_of(kFilesHash) != files)
    return fmt::format("was made from other files: {} {}, not {}", kFilesHash, input_of(kFilesHash), files);
  for (const auto& [name, value] : tracer.items()) {
    if (inputs.contains(name) && value != inputs.at(name)) {
      return fmt::format("was made with {} = {}, not {}", name, inputs.at(name), value.get<std::string>());
    }
  }
  return "";
}

/// Whether an existing trace file is valid and matches its key.
bool matches_key(const std::string& trace, const std::string& files, const ordered_json& tracer) {
  try {
    return mismatch(trace, files, tracer).empty();
  } catch (const Error&) {
    return false;
  }
}

/// A generated scene: made once, with its hash in a note file beside it.
class GeneratedScene {
 public:
  GeneratedScene(const ordered_json& task, const Commands& commands)
      : task_(task), commands_(commands), scene_(task.at("scene")), cameras_(task.at("cameras")) {}

  /// FilesRead::hash() of the generated files; generates them if there is no note.
  std::string files() const {
    if (const std::string made = recorded_hash(); !made.empty()) return made;
    std::vector<std::string> arguments = texts(task_.at("synth"));
    const std::string made = commands_.file("scene.ply"), made_cameras = commands_.file("scene.cameras.json");
    arguments.insert(arguments.end(), {"-o", made, "--quiet"});
    commands_.run("synth", arguments);
    FilesRead files;
    files.read(made_cameras);
    files.read(made);
    // The note is written last: if it exists, so do the files. Another task may write the same bytes at the same time.
    fs::rename(made_cameras, cameras_);
    fs::rename(made, scene_);
    write_file(hash_file(), files.hash());
    return files.hash();
  }
  /// Call if the files do not match the note: the next files() generates them again.
  void forget() const { fs::remove(hash_file()); }

 private:
  std::string hash_file() const { return scene_ + ".hash"; }
  /// The hash in the note; "" if there is none (another task may be generating the scene).
  std::string recorded_hash() const {
    try {
      return fs::exists(scene_) ? read_file(hash_file()) : "";
    } catch (const Error&) {
      return "";
    }
  }

  const ordered_json& task_;
  const Commands& commands_;
  std::string scene_, cameras_;
};

/// Cost of making a trace.
struct TraceEffort {
  double seconds = 0.0;
  std::uint64_t structures_built = 0;
};

/// tracer: shared process; null for a single trace. If a trace fails there, it is tried once more in its own process,
/// so that its status and reason do not depend on other traces.
TraceEffort make_trace(const std::vector<std::string>& arguments, const Commands& commands, TracerProcess* tracer) {
  if (tracer != nullptr) {
    const TracerProcess::Result end = tracer->trace(arguments);
    if (end.timeout) throw commands.too_long("trace");
    if (end.done) return {end.seconds, end.structures_built};
  }
  return {commands.run("trace", arguments), 1};
}

ordered_json do_trace(const ordered_json& task, const Commands& commands, TracerProcess* tracer) {
  const std::string target = task.at("target");
  const bool generated = !task.at("synth").empty();
  const GeneratedScene scene(task, commands);
  ordered_json result;
  for (bool may_retry : {true, false}) {
    const std::string files = generated ? scene.files() : task.at("files_hash").get<std::string>();
    if (matches_key(target, files, task.at("tracer"))) break;
    std::vector<std::string> arguments = {"--scene", task.at("scene"), "--cameras", task.at("cameras")};
    for (const std::string& argument : texts(task.at("arguments"))) arguments.push_back(argument);
    const std::string made = commands.file("trace.grtx");
    arguments.insert(arguments.end(), {"-o", made, "--quiet"});
    const TraceEffort effort = make_trace(arguments, commands, tracer);
    result["seconds"] = effort.seconds;
    result["structures_built"] = effort.structures_built;
    const std::string why = mismatch(made, files, task.at("tracer"));
    if (why.empty()) {
      fs::rename(made, target);
      break;
    }
    if (!generated || !may_retry) throw Failure{"failed", "trace: " + why};
    scene.forget();  // the scene file was changed
  }
  result["bytes"] = fs::file_size(target);
  return result;
}

ordered_json do_point(const ordered_json& task, const Commands& commands) {
  const std::string config = commands.file("config.toml"), statistics = commands.file("stats.json");
  write_config(config, task.at("config"));
  const std::string trace = task.at("trace");
  ordered_json result;
  try {
    result["seconds"] =
        commands.run("sim", {trace, "--config", config, "--machine", task.at("machine").get<std::string>(), "--mode",
                             task.at("mode").get<std::string>(), "--stats", statistics, "--quiet"});
  } catch (Failure& failure) {
    if (failure.status == "failed" && !is_intact(trace)) failure.status = "pending";  // the next sweep remakes it
    throw;
  }
  ordered_json document = sim::read_statistics(statistics);
  const std::string memory_files = document.at("inputs").value(std::string("memory.") + kFilesHash, "");
  if (memory_files != task.at("memory_files").get<std::string>()) {
    throw Failure{"pending", "sim: files that dram.simulator.config names were changed under way"};
  }
  ordered_json& stats = document.at("stats");
  for (auto entry = stats.begin(); entry != stats.end();) {
    entry = entry.key().starts_with("host.") ? stats.erase(entry) : std::next(entry);
  }
  result["document"] = std::move(document);
  std::vector<std::string> arguments = {"--config", config, "--json"};
  for (const std::string& argument : texts(task.at("cost"))) arguments.push_back(argument);
  commands.run("cost", arguments);
  result["cost"] = read_json(commands.file("cost.out"));
  return result;
}

/// Checks that the database can store the outcome. Throws nlohmann::json::exception.
void check_done_point(const TaskOutcome& outcome) {
  for (const ordered_json& statistic : outcome.document.at("stats")) (void)statistic.at("value");
  (void)cost_values(outcome.cost);
}

ordered_json limits_json(const PlanLimits& limits) {
  return {{"seconds", limits.seconds}, {"memory_mb", limits.memory_mb}};
}

}  // namespace

std::string trace_name(const std::string& key) { return key + ".grtx"; }

Task trace_task(const SweepTrace& trace, const std::string& program, const std::string& folder,
                const PlanLimits& limits) {
  const bool generated = !trace.synth.empty();
  return {trace.key,
          true,
          {{"kind", "trace"},
           {"key", trace.key},
           {"program", program},
           {"limits", limits_json(limits)},
           {"synth", trace.synth},
           {"scene", generated ? folder + "/" + trace.scene_file : trace.scene_file},
           {"cameras", generated ? folder + "/" + trace.cameras : trace.cameras},
           {"files_hash", trace.files_hash},
           {"tracer", trace.options.at("tracer")},
           {"arguments", trace.arguments},
           {"target", folder + "/" + trace_name(trace.key)}}};
}

Task point_task(const SweepPoint& point, const std::string& program, const std::string& folder,
                const PlanLimits& limits) {
  return {point.key,
          false,
          {{"kind", "point"},
           {"key", point.key},
           {"program", program},
           {"limits", limits_json(limits)},
           {"trace", folder + "/" + trace_name(point.trace_key)},
           {"config", point.config.json()},
           {"memory_files", point.config.memory_files()},
           {"machine", point.machine_option},
           {"mode", point.mode},
           {"cost", cost_arguments(point.use)}}};
}

void run_tasks(const std::vector<std::string>& descriptions, const std::vector<std::string>& results,
               const std::string& scratch) {
  if (descriptions.size() != results.size()) throw Error("--task", "", "each needs a --result");
  std::optional<Scratch> folder;
  std::unique_ptr<TracerProcess> tracer;
  for (std::size_t i = 0; i < descriptions.size(); ++i) {
    const ordered_json task = read_json(descriptions[i]);
    ordered_json outcome = {{"key", task.at("key")}, {"kind", task.at("kind")}, {"status", "done"}};
    try {
      if (!folder) folder.emplace(scratch);
      const bool is_trace = task.at("kind") == "trace";
      if (is_trace && tracer == nullptr && descriptions.size() > 1) {
        tracer = std::make_unique<TracerProcess>(task.at("program").get<std::string>(), scratch, limits_of(task));
      }
      const Commands commands(task, scratch);
      outcome.update(is_trace ? do_trace(task, commands, tracer.get()) : do_point(task, commands));
    } catch (const Failure& failure) {
      outcome["status"] = failure.status;
      outcome["reason"] = failure.reason;
    } catch (const std::exception& error) {
      outcome["status"] = "failed";
      outcome["reason"] = error.what();
    }
    write_file(results[i], json_text(outcome));
  }
}

TaskOutcome read_outcome(const std::string& result) {
  try {
    const ordered_json json = read_json(result);
    TaskOutcome outcome;
    outcome.key = json.at("key");
    outcome.is_trace = json.at("kind") == "trace";
    outcome.status = json.at("status");
    outcome.reason = json.value("reason", "");
    outcome.seconds = json.value("seconds", 0.0);
    outcome.bytes = json.value("bytes", std::uint64_t{0});
    if (json.contains("structures_built")) outcome.structures_built = json.at("structures_built").get<std::uint64_t>();
    if (json.contains("document")) outcome.document = json.at("document");
    if (json.contains("cost")) outcome.cost = json.at("cost");
    if (outcome.key != fs::path(result).stem().string()) throw Error(result, "key", "must be the file's name");
    if (outcome.status == "done" && !outcome.is_trace) check_done_point(outcome);
    return outcome;
  } catch (const nlohmann::json::exception& error) {
    throw Error(result, "", std::string("is no result of a task: ") + error.what());
  }
}

}  // namespace grtx::explore
