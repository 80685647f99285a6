#include "grtx/explore/report/run_results.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <limits>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/base/json.h"
#include "grtx/rtl_tlm/run/statistics_json.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;

// Wall time and speed of the host: a report of the same simulation is the same everywhere.
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
  check_statistics(statistics, path, name + ": ");
  DesignResult design;
  design.name = name;
  design.inputs = inputs;
  design.statistics = ordered_json::object();
  for (const auto& [key, entry] : statistics.items()) {
    if (!of_the_host(key)) design.statistics[key] = entry;
  }
  return design;
}

std::string label_of(const ordered_json& inputs, const std::string& file) {
  std::string label = text(inputs, "trace.scene");
  if (label.empty()) return file;
  label = std::filesystem::path(label).stem().string();
  if (const std::string camera = text(inputs, "trace.camera"); !camera.empty()) label += ", view " + camera;
  if (const std::string k = text(inputs, "trace.k"); !k.empty()) label += ", k = " + k;
  return label;
}

void read_run(const ordered_json& document, const std::string& path, RunResults& run) {
  for (const auto& [name, statistics] : object(document, "designs", path).items()) {
    const ordered_json inputs = document.contains("inputs") ? document.at("inputs").value(name, ordered_json::object())
                                                            : ordered_json::object();
    run.designs.push_back(design_result(name, statistics, inputs, path));
    if (document.contains("binding_bound")) run.designs.back().binding_bound = text(document.at("binding_bound"), name);
  }
  if (document.contains("speedup_over")) run.speedup_over = text(document, "speedup_over");
  run.has_verdict = document.contains("images_identical") && document.at("images_identical").is_boolean();
  if (run.has_verdict) run.images_identical = document.at("images_identical").get<bool>();
  for (const ordered_json& violation : document.value("violations", ordered_json::array())) {
    run.violations.push_back(violation.is_string() ? violation.get<std::string>() : json_text(violation));
  }
  run.program = "grtx " + text(document, "version");
  for (const char* name : {"image.png", "image_0.png"}) {  // of a sequence the first frame
    const std::filesystem::path picture = std::filesystem::path(path).parent_path() / name;
    if (run.picture.empty() && std::filesystem::exists(picture)) run.picture = picture.string();
  }
}

void read_simulation(const ordered_json& document, const std::string& path, RunResults& run) {
  const ordered_json& inputs = object(document, "inputs", path);
  std::string name = design_name(text(inputs, "accel"), text(inputs, "checkpoint"));
  if (name.empty()) name = "run";
  run.designs.push_back(design_result(name, object(document, "stats", path), inputs, path));
  run.over_time = document.value("over_time", ordered_json());
  run.program = text(inputs, "program");
}

}  // namespace

double DesignResult::value(const std::string& statistic) const {
  const auto found = statistics.find(statistic);
  if (found == statistics.end() || !found->at("value").is_number()) return std::numeric_limits<double>::quiet_NaN();
  return found->at("value").get<double>();
}

const DesignResult* RunResults::design(const std::string& name) const {
  for (const DesignResult& d : designs) {
    if (d.name == name) return &d;
  }
  return nullptr;
}

std::string design_name(const std::string& accel, const std::string& checkpoint) {
  if (accel.empty() || (checkpoint != "on" && checkpoint != "off")) return "";
  const bool two_level = accel.starts_with("tlas-");
  return checkpoint == "on" ? (two_level ? "grtx" : "hw") : (two_level ? "sw" : "baseline");
}

RunResults read_run_results(const std::string& path) {
  RunResults run;
  const std::string bytes = read_file(path);
  const ordered_json document = parse_json(bytes, path);
  const std::string schema = document.is_object() ? text(document, "schema") : "";
  if (schema != "grtx.run/1" && schema != "grtx.stats/1") {
    throw Error(path, "schema", "must be grtx.run/1 (results.json of grtx run) or grtx.stats/1 (grtx sim --stats)");
  }
  run.file = std::filesystem::path(path).filename().string();
  run.hash = hex(xxh3(bytes));
  run.bytes = bytes.size();
  run.config = object(document, "config", path);
  if (schema == "grtx.run/1") {
    read_run(document, path, run);
  } else {
    read_simulation(document, path, run);
  }
  if (run.designs.empty()) throw Error(path, "designs", "must not be empty");
  run.label = label_of(run.designs.front().inputs, run.file);
  const std::string machine = text(schema == "grtx.run/1" ? document : object(document, "inputs", path), "machine");
  if (!machine.empty()) {
    run.label += ", machine " + std::filesystem::path(machine).stem().string();
  }
  return run;
}

}  // namespace grtx::sim
