// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/sweep/designs.h"

#include <algorithm>
#include <charconv>
#include <system_error>

#include "grtx/base/declare/named_enum.h"
#include "grtx/modules/messages/hit_heap.h"
#include "grtx/rtl_tlm/config/config_file.h"

namespace grtx::explore {

const std::vector<Design>& designs() {
  // GauTracer: one level, a leaf of 64 B for each Gaussian; the hit is the peak of its response; heaps of hits of
  // three words in registers (keys_for()), beside the 32 that the ray generation shader is assumed to need. Rays are
  // read in four banks, nodes one a cycle and unit; eight heap logics have a row of the register file each.
  const Design::Texts heaps = {{"rt.gaussian.enabled", "true"}, {"rt.any_hit_unit.enabled", "true"},
                               {"rt.any_hit_unit.count", "8"},  {"rt.warp_buffer.ray_banks", "4"},
                               {"rt.memory.node_ports", "1"},   {"simt.registers_per_thread", "32"}};
  // Its units with heaps of 64 hits, by entry, leaves of 32 B, and warps that walk together (docs/model/warp_walk.md).
  // Its stack spills, and its nodes have six children, whatever a machine's lanes and nodes do.
  Design::Texts walk = heaps;
  walk.insert(walk.end(), {{"rt.traversal", "warp"},
                           {"rt.warp_stack.entries", "96"},
                           {"rt.warp_stack.ahead", "16"},
                           {"rt.warp_buffer.spill", "true"}});
  // k: docs/guide/designs.md#k
  static const std::vector<Design> all = {
      {"baseline",
       "20 triangles around each Gaussian, its hits to the any-hit shader, each "
       "round from the root",
       "tri20",
       false,
       {{"k", "32"}},
       {}},
      {"sw",
       "one mesh of 20 triangles that all Gaussians share, an instance for each",
       "tlas-tri20",
       false,
       {{"k", "32"}},
       {}},
      {"hw", "baseline whose rounds go on from checkpoints", "tri20", true, {{"k", "16"}}, {}},
      {"grtx", "sw whose rounds go on from checkpoints", "tlas-tri20", true, {{"k", "16"}}, {}},
      {"gautracer",
       "a leaf for each Gaussian, tested by a unit in place of triangles; its hits in "
       "heaps in registers, without a shader",
       "ellipsoid",
       false,
       {{"k", "48"}, {"sort_key", "peak"}, {"tmax_update", "kth"}},
       heaps,
       modules::HitHeap::kEntryWords},
      {"walk",
       "gautracer with smaller leaves and hits by their entry; the 32 rays of a warp "
       "share a stack, and fetch a node once for all",
       "ellipsoid",
       false,
       {{"k", "64"},
        {"sort_key", "entry"},
        {"tmax_update", "kth"},
        {"ahead", "16"},
        {"layout", "quantised"},
        {"bvh_width", "6"}},
       walk,
       modules::HitHeap::kEntryWords}};
  return all;
}

const std::vector<std::string>& design_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Design& design : designs()) all.push_back(design.name);
    return all;
  }();
  return names;
}

const Design& design_of(std::string_view name) {
  const auto found =
      std::find_if(designs().begin(), designs().end(), [&](const Design& design) { return design.name == name; });
  if (found == designs().end()) throw Error("design", std::string(name), unknown_name(name, design_names()));
  return *found;
}

std::map<std::string, std::string> tracer_of(const Design& design, std::map<std::string, std::string> machine,
                                             const std::map<std::string, std::string>& named) {
  for (const auto& [name, value] : design.tracer) machine[name] = value;
  for (const auto& [name, value] : named) machine[name] = value;
  return machine;
}

unsigned k_of(const Design& design, const std::string& text) {
  unsigned given = 0;
  if (std::from_chars(text.data(), text.data() + text.size(), given).ec == std::errc()) return given;
  return static_cast<unsigned>(
      std::stoul(std::ranges::find(design.tracer, "k", &std::pair<std::string, std::string>::first)->second));
}

Design::Texts keys_for(const Design& design, unsigned k) {
  Design::Texts keys = design.keys;
  if (design.registers_per_hit != 0) {
    keys.emplace_back("simt.payload_registers", std::to_string(std::min(design.registers_per_hit * k, 255U)));
  }
  return keys;
}

sim::GpuConfig with_keys_of(const Design& design, unsigned k, sim::GpuConfig config,
                            const std::set<std::string>& named) {
  const std::vector<modules::Parameter> keys = sim::config_keys(config);
  for (const auto& [key, value] : keys_for(design, k)) {
    if (!named.contains(key)) sim::apply_setting(key + "=" + value, keys);
  }
  return config;
}

std::set<std::string> keys_of(const std::vector<std::string>& settings) {
  std::set<std::string> keys;
  for (const std::string& setting : settings) keys.insert(setting.substr(0, setting.find('=')));
  return keys;
}

}  // namespace grtx::explore
