// SPDX-License-Identifier: Apache-2.0
// grtx selftest: checks that this program gives the recorded results on this host. Makes a scene, traces and simulates
// it with the program's own commands, and compares hashes and numbers, none of which depends on the host.
#include "grtx/apps/grtx/selftest.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "grtx/apps/grtx/json_output.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/base/json.h"
#include "grtx/explore/sweep/program_run.h"

namespace grtx::apps {
namespace {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

/// A step and its expected result: lines of "name value".
struct Step {
  const char* name;
  const char* golden;
};

// Output of `grtx selftest --print`; update it after changes that are meant to alter results.
constexpr std::array<Step, 5> kSteps = {{
    {"synth", R"(scene 65e4a5d5d42fb0c1
cameras 05354103d10ab118
)"},
    {"trace", R"(image ee86c7a374cb0719
)"},
    {"check", ""},
    {"cycle", R"(baseline 5145536 4121 1351982 23008 1456673 1082162 29425 0 3576538 950537 6187968 613444
sw 451840 4121 1581226 23008 1606917 1021324 32538 0 4255226 457484 321568 709414
hw 5145536 4121 630425 23008 968650 476444 15754 132496 1994966 733817 9318848 338966
grtx 451840 4121 715414 23008 818511 469459 15433 119069 2322119 505667 4939264 365263
gautracer 257280 3571 501033 24207 314070 265469 0 0 849015 82875 201248 53418
)"},
    {"mechanisms", R"(rt.scheduler.policy=round_robin 848184 2388786 521156 5528992
rt.checkpoint.write_combine=true 816929 2216419 400242 5687200
rt.any_hit_unit.enabled=true 787012 2060984 388832 5345344
rt.prefetch.enabled=false 808969 2086792 517027 5659008
l1.replacement=random 830711 2307720 564387 5636000
)"},
}};

/// Statistics compared for each design of `grtx run`.
constexpr std::array<const char*, 12> kStatistics = {
    "accel.bytes",     "tracer.rounds",       "tracer.visits.total",    "tracer.blended",
    "gpu.cycles",      "gpu.rt.node_fetches", "gpu.rt.any_hit.batches", "gpu.rt.checkpoint.entries_written",
    "gpu.l1.accesses", "gpu.l2.accesses",     "gpu.dram.bytes",         "gpu.simt.instructions.total"};

/// Statistics compared for each run of the step "mechanisms": the trace of the step "trace" in cycle mode, with one
/// mechanism switched from its default.
constexpr std::array<const char*, 4> kFewStatistics = {"gpu.cycles", "gpu.l1.accesses", "gpu.l2.accesses",
                                                       "gpu.dram.bytes"};
constexpr std::array<const char*, 5> kMechanisms = {"rt.scheduler.policy=round_robin",
                                                    "rt.checkpoint.write_combine=true", "rt.any_hit_unit.enabled=true",
                                                    "rt.prefetch.enabled=false", "l1.replacement=random"};
/// Machine of the recorded results.
constexpr const char* kMachine = "paper-charged";
/// Settings that reduce the machine, and its queue as it was when the results were recorded.
constexpr std::array<const char*, 4> kPart = {"gpu.sms=2", "l2.bytes=1048576", "l2.slices=1", "rt.memory.queue=64"};

/// Runs the program's commands in a temporary folder, which is removed at the end.
class Selftest {
 public:
  /// Throws Error if no temporary folder can be made.
  Selftest() {
    std::error_code failed;
    folder_ = fs::temp_directory_path(failed) / fmt::format("grtx_selftest_{}", ::getpid());
    if (!failed) fs::create_directories(folder_, failed);
    if (failed) throw Error("selftest", "", "no temporary folder (TMPDIR): " + failed.message());
  }
  ~Selftest() {
    std::error_code failed;
    fs::remove_all(folder_, failed);
  }
  Selftest(const Selftest&) = delete;
  Selftest& operator=(const Selftest&) = delete;

  /// Result of a step: lines of "name value", or one line that begins with "error".
  std::string result(const std::string& step) {
    if (step == "synth") {
      const std::string error =
          call({"synth", "--preset", "flat", "--count", "3000", "--seed", "5", "-o", file("scene.ply")});
      return error.empty() ? hash_line("scene", "scene.ply") + hash_line("cameras", "scene.cameras.json") : error;
    }
    if (step == "trace") {
      const std::string error = traced({"--child-order", "near_first", "--accel", "tlas-tri20", "--checkpoint", "on",
                                        "-o", file("t.grtx"), "--image", file("image.pfm")});
      return error.empty() ? hash_line("image", "image.pfm") : error;
    }
    if (step == "check") return call({"trace-check", file("t.grtx")});
    if (step == "mechanisms") return mechanisms();
    std::vector<std::string> run = {
        "run", "--machine", kMachine, "--mode", step, "--k", "8", "--designs", "baseline,sw,hw,grtx,gautracer",
        "-o",  file(step)};
    for (const char* setting : kPart) run.insert(run.end(), {"--set", setting});
    const std::string error = with_view(run);
    return error.empty() ? statistics_lines(step + "/results.json") : error;
  }

 private:
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  std::string hash_line(const std::string& what, const std::string& name) const {
    return fmt::format("{} {}\n", what, hex(xxh3(read_file(file(name)))));
  }

  std::string statistics_lines(const std::string& name) const {
    const ordered_json results = read_json(file(name));
    std::string lines;
    for (const auto& [design, statistics] : results.at("designs").items()) {
      lines += line_of(design, statistics, kStatistics);
    }
    return lines;
  }

  template <std::size_t count>
  static std::string line_of(const std::string& name, const ordered_json& statistics,
                             const std::array<const char*, count>& names) {
    std::string line = name;
    for (const char* statistic : names) {
      line += fmt::format(" {}", statistics.at(statistic).at("value").get<std::uint64_t>());
    }
    return line + '\n';
  }

  std::string mechanisms() {
    std::string lines;
    for (const std::string setting : kMechanisms) {
      std::vector<std::string> arguments = {"sim", file("t.grtx"), "--machine", kMachine, "--stats", file("s.json")};
      for (const char* part : kPart) arguments.insert(arguments.end(), {"--set", part});
      arguments.insert(arguments.end(), {"--set", setting});
      if (const std::string error = call(arguments); !error.empty()) return error;
      lines += line_of(setting, read_json(file("s.json")).at("stats"), kFewStatistics);
    }
    return lines;
  }

  std::string traced(const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"trace"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return with_view(arguments);
  }

  std::string with_view(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--scene", file("scene.ply"), "--cameras", file("scene.cameras.json"), "--width",
                                       "32", "--height", "32"});
    return call(arguments);
  }

  /// Runs a command; returns "" on success, else an error line.
  std::string call(const std::vector<std::string>& arguments) {
    std::vector<std::string> all = {fs::read_symlink("/proc/self/exe").string()};
    all.insert(all.end(), arguments.begin(), arguments.end());
    all.emplace_back("--quiet");
    const explore::ProgramEnd end =
        explore::ProgramRun(all, file("out"), file("errors"), explore::ProgramLimits{300.0, 0}).wait();
    if (end.code == 0 && end.signal == 0) return "";
    const std::string why = end.timeout       ? "longer than 300 s"
                            : end.signal != 0 ? "ended by " + explore::signal_name(end.signal)
                                              : read_file(file("errors"));
    return fmt::format("error {}: {}\n", arguments.front(), why.substr(0, why.find('\n')));
  }

  fs::path folder_;
};

/// Lines of `golden` and `found` that differ, as one text.
std::string first_difference(std::string golden, std::string found) {
  const auto next = [](std::string& text) {
    const std::string line = text.substr(0, text.find('\n'));
    text.erase(0, line.size() + 1);
    return line;
  };
  while (!golden.empty() || !found.empty()) {
    const std::string a = next(golden), b = next(found);
    if (a != b) return fmt::format("expected '{}', found '{}'", a, b);
  }
  return "";
}

int selftest(bool print, bool as_json, bool quiet) {
  ordered_json json = json_document("selftest");
  Selftest test;
  bool ok = true;
  for (const Step& step : kSteps) {
    const std::string found = test.result(step.name);
    if (print && as_json) {
      json["found"][step.name] = found;
      continue;
    }
    if (print) {
      fmt::print("{}:\n{}", step.name, found);
      continue;
    }
    const std::string difference = first_difference(step.golden, found);
    if (as_json) {
      json["steps"].push_back({{"step", step.name}, {"ok", difference.empty()}, {"difference", difference}});
    } else if (!quiet || !difference.empty()) {
      fmt::print("{:<6} {}\n", step.name, difference.empty() ? "OK" : difference);
    }
    ok = ok && difference.empty();
  }
  if (as_json) {
    if (!print) json["ok"] = ok;
    print_json(json);
  } else if (!print && (!quiet || !ok)) {
    fmt::print("{}\n", ok ? "OK" : "FAILED");
  }
  return ok ? 0 : 1;
}

}  // namespace

void add_selftest(CLI::App& app, CommonOptions& common) {
  const auto print = std::make_shared<bool>(false);
  CLI::App* command =
      make_command(app, common, "selftest", "Small runs against hashes and numbers on record; OK in under a minute",
                   [print, &common] { return selftest(*print, common.json, common.quiet); });
  command->add_flag("--print", *print, "Print this program's results instead of comparing them (default: off)");
}

}  // namespace grtx::apps
