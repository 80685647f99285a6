// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/run/result_notes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <optional>
#include <utility>

#include "grtx/base/error.h"
#include "grtx/base/printable.h"

namespace grtx::sim {
namespace {

std::optional<double> value_of(const modules::StatisticList& list, std::string_view name) {
  for (const modules::Statistic& s : list.items()) {
    if (s.name == name) return std::visit([](auto value) { return static_cast<double>(value); }, s.value);
  }
  return std::nullopt;
}

/// A launch with fewer warps than slots is all tail: no warp takes the place of one that has ended. One of a few more
/// is mostly tail, as that of a machine whose registers leave few slots.
void add_partial_launch(const GpuConfig& config, const traces::Header& header, std::uint64_t groups,
                        const modules::StatisticList& statistics, ResultNotes& notes) {
  const std::uint64_t slots = std::uint64_t{config.sms} * config.resident();
  const auto& frames = header.frame_groups;
  const std::uint64_t launch = frames.empty() ? groups : *std::max_element(frames.begin(), frames.end());
  // The tail is that of the last launch, of a sequence its last frame's.
  const std::string timed = frames.empty() ? "gpu" : fmt::format("gpu.frame{}", frames.size() - 1);
  const char* const of = frames.empty() ? "run" : "last frame";
  const double cycles = value_of(statistics, timed + ".cycles").value_or(0.0);
  const double tail = value_of(statistics, "gpu.distributor.tail_cycles").value_or(0.0);
  if (launch >= slots && tail <= kMostTail * cycles) return;
  if (launch >= slots) {
    notes.push_back(
        {"partial-launch",
         fmt::format("a launch of {} warps fills {} warp slots for a short time only; after the last warp has "
                     "started, {:.0f} % of the {} is tail",
                     launch, slots, 100.0 * tail / cycles, of)});
    return;
  }
  notes.push_back(
      {"partial-launch",
       fmt::format("a launch of {} warps does not fill {} warp slots, the machine is never full; after the last "
                   "warp has started, {:.0f} % of the {} is tail",
                   launch, slots, cycles == 0.0 ? 100.0 : 100.0 * tail / cycles, of)});
}

/// Only for an L1 that counts dropped fills.
void add_dropped_fills(const modules::StatisticList& statistics, ResultNotes& notes) {
  constexpr double kToleratedShare = 0.001;
  const double fills = value_of(statistics, "gpu.l1.fills").value_or(0.0);
  const double dropped = value_of(statistics, "gpu.l1.fills_bypassed").value_or(0.0);
  if (dropped <= kToleratedShare * fills) return;
  notes.push_back(
      {"dropped-fills", fmt::format("{:.1f} % of the fills of the L1 were dropped, their victims found no room: raise "
                                    "l1.write_back_buffer",
                                    100.0 * dropped / fills)});
}

/// Notes where the trace has more than the machine has room for, and the excess would cost nothing.
void add_exceeded_resources(const GpuConfig& config, const traces::Header& header, ResultNotes& notes) {
  const std::uint64_t words = std::uint64_t{header.k} * modules::HitHeap::kEntryWords;
  if (config.rt.any_hit_unit.enabled && words > config.simt.register_file.payload_registers) {
    notes.push_back({"heap-registers",
                     fmt::format("heaps of {} hits need {} registers of a thread, and simt.payload_registers = {}",
                                 header.k, words, config.simt.register_file.payload_registers)});
  }
  if (config.rt.walks() && header.ahead < config.rt.warp_stack.ahead) {
    notes.push_back(
        {"ahead", fmt::format("rt.warp_stack.ahead = {} nodes are under way, and t_max of the trace is that of "
                              "{}: trace with --ahead {}",
                              config.rt.warp_stack.ahead, header.ahead, config.rt.warp_stack.ahead)});
  }
}

}  // namespace

ResultNotes trace_notes(const traces::Header& header, const traces::Totals& totals) {
  ResultNotes notes;
  if (totals.any_hit_calls == 0) {
    notes.push_back({"no-hits",
                     "no ray met a Gaussian: are the cameras of another scene? Rays that miss are all that "
                     "was measured"});
  }
  if (totals.overflows > 0) {
    notes.push_back({"overflow", fmt::format("in {} of {} rounds a list of {} checkpoints was full, and the next round "
                                             "began at the root: raise --checkpoint-capacity",
                                             totals.overflows, totals.rounds, header.checkpoint_capacity)});
  }
  if (const auto clamped = header.inputs.find("clamped"); clamped != header.inputs.end()) {
    notes.push_back({"clamped", "reading the scene changed " + clamped->second});
  }
  if (const auto clamped = header.inputs.find("clamped_sh"); clamped != header.inputs.end()) {
    notes.push_back({"clamped-sh", "layout quantised changed " + clamped->second +
                                       " channels of spherical harmonics: beyond 65,504, the most that fp16 holds"});
  }
  return notes;
}

ResultNotes run_notes(const GpuConfig& config, const traces::Header& header, std::uint64_t groups,
                      const modules::StatisticList& statistics) {
  ResultNotes notes;
  if (config.resident() < config.resident_warps) {
    notes.push_back({"fewer-slots", fmt::format("the registers of an SM hold {} warps, not gpu.resident_warps = {}",
                                                config.resident(), config.resident_warps)});
  }
  add_exceeded_resources(config, header, notes);
  add_partial_launch(config, header, groups, statistics, notes);
  add_dropped_fills(statistics, notes);
  return notes;
}

nlohmann::ordered_json notes_json(const ResultNotes& notes) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const ResultNote& note : notes) json.push_back({{"id", note.id}, {"text", note.text}});
  return json;
}

ResultNotes notes_from(const nlohmann::ordered_json& json, const std::string& path) {
  const auto is_text = [](const nlohmann::ordered_json& note, const char* member) {
    return note.is_object() && note.contains(member) && note.at(member).is_string();
  };
  ResultNotes notes;
  if (!json.is_array()) throw Error(path, "notes", "must be a list");
  for (const nlohmann::ordered_json& note : json) {
    if (!is_text(note, "id") || !is_text(note, "text")) throw Error(path, "notes", "each must have an id and a text");
    notes.push_back({note.at("id").get<std::string>(), note.at("text").get<std::string>()});
  }
  return notes;
}

void print_notes(const std::map<std::string, ResultNotes>& by_design) {
  std::vector<std::pair<std::string, std::vector<std::string>>>
      designs_by_text;  // designs by text, in order of first appearance
  for (const auto& [design, notes] : by_design) {
    for (const ResultNote& note : notes) {
      const auto known = std::find_if(designs_by_text.begin(), designs_by_text.end(),
                                      [&](const auto& entry) { return entry.first == note.text; });
      (known == designs_by_text.end() ? designs_by_text.emplace_back(note.text, std::vector<std::string>()) : *known)
          .second.push_back(design);
    }
  }
  for (const auto& [text, designs] : designs_by_text)
    fmt::print(stderr, "grtx: {}: {}\n", fmt::join(designs, ", "), printable(text));
}

}  // namespace grtx::sim
