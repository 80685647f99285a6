// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/page/run_results.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/base/json.h"
#include "grtx/rtl_tlm/run/statistics_json.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;

// Statistics of the host, left out so that a report does not depend on it.
bool of_the_host(const std::string& name) {
  return name.starts_with("host.") || name == "tracer.wall_seconds" || name == "tracer.rays_per_second" ||
         name == "tracer.visits_per_second" || name == "accel.build_seconds" || name == "accel.pack_seconds" ||
         name == "accel.update.seconds";
}

const ordered_json& object(const ordered_json& parent, const char* name, const std::string& path) {
  if (!parent.contains(name) || !parent.at(name).is_object()) throw Error(path, name, "must be an object");
  return parent.at(name);
}

std::string text(const ordered_json& parent, const std::string& name) {
  return parent.contains(name) && parent.at(name).is_string() ? parent.at(name).get<std::string>() : "";
}

DesignResult design_result(const std::string& name, const ordered_json& statistics, const ordered_json& inputs,
                           const std::string& path) {
  sim::check_statistics(statistics, path, name + ": ");
  DesignResult design;
  design.name = name;
  design.inputs = inputs;
  design.statistics = ordered_json::object();
  for (const auto& [key, entry] : statistics.items()) {
    if (!of_the_host(key)) design.statistics[key] = entry;
  }
  return design;
}

/// Finds the picture named in results.json and checks its hash: another run may have replaced the file.
void find_picture(const ordered_json& document, const std::string& path, RunResults& run) {
  const ordered_json images = document.value("images", ordered_json::array());
  if (!images.is_array() || images.empty()) return;
  const std::string file = images.front().is_object() ? text(images.front(), "file") : "";
  if (file.empty() || std::filesystem::path(file).filename() != file) {
    throw Error(path, "images", "must be a list of files in the same folder, each with its hash");
  }
  const std::filesystem::path picture = std::filesystem::path(path).parent_path() / file;
  if (!std::filesystem::exists(picture)) {
    run.picture_problem = file + " is not beside " + run.file;
  } else if (hex(xxh3(read_file(picture.string()))) != text(images.front(), "hash")) {
    run.picture_problem = file + " beside " + run.file + " is not the picture of this run";
  } else {
    run.picture = picture.string();
  }
}

/// Reads intervals {"low", "high"} by design.
std::map<std::string, Interval> intervals(const ordered_json& document, const char* name) {
  std::map<std::string, Interval> all;
  const ordered_json by_design = document.value(name, ordered_json::object());
  for (const auto& [design, interval] : by_design.items()) {
    if (!interval.is_object() || !interval.contains("low") || !interval.contains("high")) continue;
    if (!interval.at("low").is_number() || !interval.at("high").is_number()) continue;
    const Interval found{interval.at("low").get<double>(), interval.at("high").get<double>()};
    if (found.low < found.high) all[design] = found;
  }
  return all;
}

/// dB by frame; null: the pictures are identical.
std::vector<double> decibels(const ordered_json& picture, const char* name, const std::string& path) {
  std::vector<double> list;
  for (const ordered_json& psnr : picture.value(name, ordered_json::array())) {
    if (!psnr.is_null() && !psnr.is_number())
      throw Error(path, std::string("pictures.") + name, "must be a list of dB");
    list.push_back(psnr.is_null() ? std::numeric_limits<double>::infinity() : psnr.get<double>());
  }
  return list;
}

std::optional<PictureResult> picture_of(const ordered_json& document, const std::string& design,
                                        const std::string& path) {
  if (!document.contains("pictures") || !object(document, "pictures", path).contains(design)) return std::nullopt;
  const ordered_json& own = object(document.at("pictures"), design.c_str(), path);
  return PictureResult{text(own, "order"), text(own, "reference") == "fp64", own.value("reference_pixels", 0.0),
                       decibels(own, "psnr", path), decibels(own, "psnr_reference", path)};
}

std::vector<double> frame_speedups(const ordered_json& document, const std::string& design) {
  const ordered_json frames = document.value("frames", ordered_json::object());
  const ordered_json all = frames.is_object() ? frames.value("speedup", ordered_json::object()) : ordered_json();
  std::vector<double> list;
  if (!all.is_object() || !all.contains(design) || !all.at(design).is_array()) return list;
  for (const ordered_json& own : all.at(design)) list.push_back(own.is_number() ? own.get<double>() : std::nan(""));
  return list;
}

/// Values over time by name; null if the simulation recorded none.
ordered_json over_time_of(const ordered_json& document, const std::string& path) {
  if (!document.contains("over_time")) return {};
  const ordered_json& all = object(document, "over_time", path);
  for (const auto& [name, series] : all.items()) {
    const auto holds = [&](const char* key, auto is) { return !series.contains(key) || (series.at(key).*is)(); };
    if (!series.is_object() || !series.contains("values") || !holds("values", &ordered_json::is_array) ||
        !holds("unit", &ordered_json::is_string) || !holds("description", &ordered_json::is_string)) {
      throw Error(path, "over_time." + name, "must have a list of values, and unit and description as texts");
    }
  }
  return all;
}

/// Whether a schema is that of results.json: grtx.run/1 had no machines beside each other.
bool is_of_run(const std::string& schema) { return schema == "grtx.run/2" || schema == "grtx.run/1"; }

/// The document that a run on this machine alone would have written. machine: a member of `machines`.
ordered_json document_of(const ordered_json& results, const ordered_json& machine) {
  ordered_json own = results;
  for (const char* of_all : {"machines", "between_machines", "violations"}) own.erase(of_all);
  own.update(machine);
  const std::string name = text(machine, "machine"), whose = " on " + name.substr(0, name.find(',')) + ": ";
  own["violations"] = ordered_json::array();
  for (const ordered_json& violation : results.value("violations", ordered_json::array())) {
    const bool of_it =
        violation.is_string() && violation.get_ref<const std::string&>().find(whose) != std::string::npos;
    if (of_it) own["violations"].push_back(violation);
  }
  return own;
}

void read_run(const ordered_json& document, const std::string& path, RunResults& run) {
  const ordered_json all_inputs =
      document.contains("inputs") ? object(document, "inputs", path) : ordered_json::object();
  const ordered_json brought =
      document.contains("design_config") ? object(document, "design_config", path) : ordered_json::object();
  for (const auto& [name, statistics] : object(document, "designs", path).items()) {
    const ordered_json inputs = all_inputs.value(name, ordered_json::object());
    run.designs.push_back(design_result(name, statistics, inputs, path));
    run.designs.back().config = run.config;
    if (brought.contains(name)) run.designs.back().config.update(object(brought, name.c_str(), path));
    run.designs.back().picture = picture_of(document, name, path);
    run.designs.back().frame_speedups = frame_speedups(document, name);
    if (const auto all = document.find("over_time"); all != document.end() && all->contains(name)) {
      run.designs.back().over_time = over_time_of({{"over_time", all->at(name)}}, path);
    }
    if (document.contains("binding_bound")) run.designs.back().binding_bound = text(document.at("binding_bound"), name);
    if (const auto notes = document.find("notes"); notes != document.end() && notes->contains(name)) {
      run.designs.back().notes = sim::notes_from(notes->at(name), path);
    }
  }
  run.speedup_intervals = intervals(document, "speedup_interval");
  if (document.contains("speedup_over")) run.speedup_over = text(document, "speedup_over");
  run.has_verdict = document.contains("images_identical") && document.at("images_identical").is_boolean();
  if (run.has_verdict) run.images_identical = document.at("images_identical").get<bool>();
  for (const ordered_json& violation : document.value("violations", ordered_json::array())) {
    run.violations.push_back(violation.is_string() ? violation.get<std::string>() : json_text(violation));
  }
  if (document.contains("left_out")) {
    for (const auto& [name, why] : object(document, "left_out", path).items()) {
      run.left_out[name] = why.is_string() ? why.get<std::string>() : json_text(why);
    }
  }
  run.program = "grtx " + text(document, "version");
  find_picture(document, path, run);  // the first frame of a sequence
}

void read_simulation(const ordered_json& document, const std::string& path, RunResults& run) {
  const ordered_json& inputs = object(document, "inputs", path);
  std::string name = design_name(inputs, run.config);
  if (name.empty()) name = "run";
  run.designs.push_back(design_result(name, object(document, "stats", path), inputs, path));
  run.designs.back().config = run.config;
  if (document.contains("notes")) run.designs.back().notes = sim::notes_from(document.at("notes"), path);
  run.designs.back().over_time = over_time_of(document, path);
  run.program = text(inputs, "program");
}

}  // namespace

std::size_t frames_of(const ordered_json& statistics) {
  std::size_t frames = 0;
  while (statistics.contains(fmt::format("gpu.frame{}.cycles", frames))) ++frames;
  return std::max<std::size_t>(1, frames);
}

std::string frame_text(std::size_t frames) {
  return frames == 1 ? "the frame" : fmt::format("a frame, mean of {}", frames);
}

double DesignResult::value(const std::string& statistic) const {
  const auto found = statistics.find(statistic);
  if (found == statistics.end() || !found->at("value").is_number()) return std::numeric_limits<double>::quiet_NaN();
  return found->at("value").get<double>();
}

double DesignResult::frame_seconds() const { return value("gpu.time_us") * 1e-6 / static_cast<double>(frames()); }

std::optional<Interval> DesignResult::cycles_interval() const {
  return grtx::report::cycles_interval([this](const char* statistic) { return value(statistic); });
}

std::optional<Interval> ratio_of(const std::optional<Interval>& over, const std::optional<Interval>& of) {
  if (!over || !of) return std::nullopt;
  return Interval{over->low / of->high, over->high / of->low};
}

std::optional<Interval> RunResults::speedup_interval(const DesignResult& own) const {
  if (const auto known = speedup_intervals.find(own.name); known != speedup_intervals.end()) return known->second;
  const DesignResult* reference = design(speedup_over);
  if (reference == nullptr || reference->name == own.name) return std::nullopt;
  return ratio_of(reference->cycles_interval(), own.cycles_interval());
}

const DesignResult* RunResults::design(const std::string& name) const {
  for (const DesignResult& d : designs) {
    if (d.name == name) return &d;
  }
  return nullptr;
}

std::string label_of(const RunResults& run) {
  std::string k = run.subject.setting("k"), others;
  for (const DesignResult& design : run.designs) {
    const std::string own = design.subject.setting("k");
    if (own != k) others += (others.empty() ? "" : ", ") + design.name + " " + (own.empty() ? "unknown" : own);
  }
  if (!others.empty()) k += " (" + others + ")";
  std::string label = run.subject.scene().empty() ? run.file : "";
  if (const std::string subject = run.subject.text(k); !subject.empty()) label += (label.empty() ? "" : ", ") + subject;
  return label;
}

namespace {

RunResults results_of(const ordered_json& document, const std::string& path, const std::string& bytes) {
  RunResults run;
  const bool of_run = is_of_run(text(document, "schema"));
  run.file = std::filesystem::path(path).filename().string();
  run.hash = hex(xxh3(bytes));
  run.bytes = bytes.size();
  run.config = object(document, "config", path);
  if (of_run) {
    read_run(document, path, run);
  } else {
    read_simulation(document, path, run);
  }
  if (run.designs.empty()) throw Error(path, "designs", "must not be empty");
  std::map<std::string, std::string> more;  // recorded once for all designs of a run
  if (of_run) more["machine"] = text(document, "machine");
  if (const auto version = document.find("model_version"); version != document.end()) {
    more["model_version"] = version->dump();
  }
  for (DesignResult& design : run.designs) design.subject = Subject(design.inputs, design.config, more);
  run.subject = run.designs.front().subject;
  run.label = label_of(run);
  return run;
}

}  // namespace

std::vector<RunResults> read_run_results(const std::string& path) {
  const std::string bytes = read_file(path);
  const ordered_json document = parse_json(bytes, path);
  const std::string schema = document.is_object() ? text(document, "schema") : "";
  if (!is_of_run(schema) && schema != "grtx.stats/1") {
    throw Error(path, "schema",
                "must be grtx.run/2 or grtx.run/1 (results.json of grtx run) or grtx.stats/1 (grtx sim --stats)");
  }
  if (!is_of_run(schema) || !document.contains("machines")) return {results_of(document, path, bytes)};
  const ordered_json& machines = document.at("machines");
  if (!machines.is_array() || machines.empty()) throw Error(path, "machines", "must be a list of machines");
  std::vector<RunResults> runs;
  for (const ordered_json& machine : machines) {
    if (!machine.is_object()) throw Error(path, "machines", "must be a list of objects");
    runs.push_back(results_of(document_of(document, machine), path, bytes));
  }
  return runs;
}

}  // namespace grtx::report
