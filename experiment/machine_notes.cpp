// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/machine_notes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/experiment/machine.h"
#include "grtx/experiment/tracer_settings.h"

namespace grtx::experiment {
namespace {

using Options = std::map<std::string, std::string>;

/// Options that a machine may choose: all that any machine sets. The user chooses all others.
std::set<std::string> options_of_machines(const Options& own) {
  std::set<std::string> names;
  for (const auto& [name, value] : own) names.insert(name);
  for (const std::string& machine : machine_names()) {
    for (const auto& [name, value] : machine_tracer(machine)) names.insert(name);
  }
  return names;
}

/// All options with this machine's values, for traces of this node layout.
Options resolved(const Options& own, const traces::Header& header) {
  TracerSettings settings;
  apply_tracer(settings, own);
  if (!own.contains("layout")) settings.layout = header.layout;  // the layout determines the default BVH width
  return option_texts(settings);
}

/// Whether the trace was made as the design's are, with any k.
bool is_of(const traces::Header& header, const explore::Design& design) {
  return name_of(header.accel) == design.accel && header.checkpoint == design.checkpoint &&
         header.tracing == traces::Tracing::multi &&
         std::all_of(design.tracer.begin(), design.tracer.end(), [&](const auto& option) {
           const auto given = header.inputs.find(option.first);
           return option.first == "k" || (given != header.inputs.end() && given->second == option.second);
         });
}

/// The first in which a trace is not the design's; "" if it is.
std::string misfit(const Options& inputs, const explore::Design& design) {
  Options wanted = {{"tracing", std::string(name_of(traces::Tracing::multi))}, {"ahead", "1"}};
  wanted =
      explore::tracer_of(design, wanted, {{"accel", design.accel}, {"checkpoint", design.checkpoint ? "on" : "off"}});
  const Options usual = option_texts({});
  for (const char* name : {"accel", "checkpoint", "tracing", "ahead", "layout"}) {
    const auto want = wanted.find(name);
    if (want == wanted.end()) continue;
    const auto given = inputs.find(name);
    const auto otherwise = usual.find(name);
    const std::string value = given != inputs.end() ? given->second : otherwise != usual.end() ? otherwise->second : "";
    if (value != want->second) {
      return fmt::format("{} is {}, not {}", name, value.empty() ? "unknown" : value, want->second);
    }
  }
  return "";
}

}  // namespace

sim::ResultNotes tracer_notes(const std::string& machine, const Options& own, const explore::Design* design,
                              const traces::Header& header) {
  if (machine.empty() || !header.inputs.contains("child_order")) return {};
  const Options whole = design == nullptr ? own : explore::tracer_of(*design, own, {});
  const Options wanted = resolved(whole, header), usual = option_texts({});
  Options differing;  // secondary rays are not among them: traces do not name their options
  for (const auto& [name, want] : wanted) {
    const bool of_checkpoints = name.starts_with("checkpoint_") || name == "below_instance";
    if (of_checkpoints && !header.checkpoint) continue;
    const auto given = header.inputs.find(name);
    const auto otherwise = usual.find(name);
    const std::string value = given != header.inputs.end() ? given->second
                              : otherwise != usual.end()   ? otherwise->second
                                                           : "absent";
    if (value != want) differing[name] = fmt::format("{} is {}, not {}", name, value, want);
  }
  if (differing.empty()) return {};  // and no machine is read
  std::vector<std::string> others;
  for (const std::string& name : options_of_machines(own)) {
    if (const auto other = differing.find(name); other != differing.end()) others.push_back(other->second);
  }
  if (others.empty()) return {};
  return {{"tracer-options", fmt::format("the trace was not made with the tracer options of machine {}: {}",
                                         machine_name(machine), fmt::join(others, ", "))}};
}

sim::ResultNotes design_notes(const traces::Header& header, const sim::GpuConfig& config,
                              const std::set<std::string>& named) {
  for (const explore::Design& design : explore::designs()) {
    if (design.keys.empty() || !is_of(header, design)) continue;
    const nlohmann::ordered_json now = config_json(config),
                                 whole = config_json(explore::with_keys_of(design, header.k, config, named));
    std::vector<std::string> others;
    for (const auto& [key, value] : explore::keys_for(design, header.k)) {
      if (now.at(key) != whole.at(key)) others.push_back(key + " = " + value);
    }
    if (others.empty()) continue;
    return {{"design-keys", fmt::format("the trace is of design {0}, whose units this run lacks; --design {0} sets {1}",
                                        design.name, fmt::join(others, ", "))}};
  }
  return {};
}

void check_design(const std::string& file, const std::string& place, const Options& inputs,
                  const explore::Design& design) {
  const std::string wrong = misfit(inputs, design);
  if (wrong.empty()) return;
  throw Error(file, place, fmt::format("is not of design {}: {}", design.name, wrong));
}

void check_design(const std::string& file, const traces::Header& header, const explore::Design& design) {
  check_design(file, "header",
               {{"accel", std::string(name_of(header.accel))},
                {"checkpoint", header.checkpoint ? "on" : "off"},
                {"tracing", std::string(name_of(header.tracing))},
                {"ahead", std::to_string(header.ahead)},
                {"layout", std::string(name_of(header.layout))}},
               design);
}

std::map<std::string, std::string> traced_inputs(const nlohmann::ordered_json& inputs) {
  constexpr std::string_view kTrace = "trace.";
  Options traced;
  for (const auto& [name, value] : inputs.items()) {
    if (!value.is_string()) continue;
    if (name.starts_with(kTrace)) traced[name.substr(kTrace.size())] = value.get<std::string>();
    traced.try_emplace(name, value.get<std::string>());
  }
  return traced;
}

std::string design_with_units(const Options& inputs) {
  for (const explore::Design& design : explore::designs()) {
    if (!design.keys.empty() && misfit(inputs, design).empty()) return design.name;
  }
  return "";
}

void put_first(sim::ResultNotes notes, nlohmann::ordered_json& document) {
  const sim::ResultNotes behind = sim::notes_from(document.at("notes"), "result");
  notes.insert(notes.end(), behind.begin(), behind.end());
  document["notes"] = sim::notes_json(notes);
}

}  // namespace grtx::experiment
