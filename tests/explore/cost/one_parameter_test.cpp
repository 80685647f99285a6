// SPDX-License-Identifier: Apache-2.0
// A parameter is stated once: changing a configuration key changes the simulated machine and the priced machine
// together, or only one of them for the reason given here. A key that is not in the table fails, so a new key must be
// classified.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <variant>

#include "grtx/base/child_process.h"
#include "grtx/explore/cost/cost_report.h"
#include "grtx/explore/cost/run_energy.h"
#include "grtx/rtl_tlm/gpu/machine.h"
#include "grtx/rtl_tlm/run/simulation.h"
#include "paths.h"
#include "rtl_tlm/plain/random_machine.h"
#include "rtl_tlm/simulate_priced.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::explore {
namespace {

using nlohmann::ordered_json;

enum class Moves { both, timing, cost };
constexpr Moves kBoth = Moves::both, kTiming = Moves::timing, kCost = Moves::cost;

struct Mutation {
  const char* key;
  const char* value;  ///< another than in configs/small.toml, small enough to be felt
  Moves moves;
  const char* why = "";                 ///< when only one moves
  std::vector<std::string> given = {};  ///< set before and after: what the key needs to matter
  const char* trace = "grtx";
};

constexpr const char* kClock = "a clock: the same circuits; leakage and energy follow from the time";
constexpr const char* kPolicy = "a choice between the same parts";
constexpr const char* kTraffic = "what is requested, by the same parts";
constexpr const char* kFixedTime = "a time of parts whose size does not follow from it";
constexpr const char* kLimitStudy = "a limit study: no hardware is meant";
constexpr const char* kAssumption = "an assumption about the same parts: who pays for their traffic";
constexpr const char* kShader = "the length of a shader, which is software";
constexpr const char* kDramChip = "of the DRAM chips, which are not priced by area";

const std::vector<Mutation>& mutations() {
  static const std::vector<Mutation> all = {
      {"gpu.sms", "4", kBoth},
      {"gpu.core_mhz", "1092", kTiming, kClock},
      {"gpu.resident_warps", "2", kBoth},
      {"gpu.rt_units", "2", kBoth},
      {"rt.warp_buffer.entries", "1", kBoth},
      {"rt.warp_buffer.stack_entries", "2", kBoth},
      {"rt.warp_buffer.spill", "false", kBoth, "", {"rt.warp_buffer.stack_entries=2"}},
      {"rt.scheduler.policy", "round_robin", kTiming, kPolicy},
      {"rt.memory.queue", "32", kBoth},
      {"rt.memory.merge_in_flight", "false", kTiming, kPolicy},
      {"rt.memory.oldest_warp_first", "true", kTiming, kPolicy},
      {"rt.memory.by_shader", "true", kBoth},
      {"rt.memory.instance_leaf_bytes", "64", kTiming, kTraffic},
      {"rt.memory.blas_header_read", "false", kTiming, kTraffic},
      {"rt.memory.leaf_descriptor_read", "true", kTiming, kTraffic},
      {"rt.memory.descriptor_wait", "40", kTiming, kTraffic, {"rt.memory.leaf_descriptor_read=true"}},
      {"rt.memory.header_wait", "40", kTiming, kTraffic},
      {"rt.memory.l1_hit_latency", "0", kTiming, kFixedTime},
      {"rt.memory.sectors_per_cycle", "4", kBoth},
      {"rt.any_hit.timeout", "4", kBoth},
      {"rt.checkpoint.lanes", "1", kBoth},
      {"rt.checkpoint.write_queue", "2", kBoth},
      {"rt.checkpoint.write_combine", "true", kBoth},
      {"rt.checkpoint.open_sectors",
       "8",
       kBoth,
       "",
       {"rt.checkpoint.entry_bytes=8", "rt.checkpoint.write_combine=true"},
       "bins"},
      {"rt.checkpoint.read_buffer", "true", kBoth},
      {"rt.checkpoint.entry_bytes", "16", kBoth},
      {"rt.checkpoint.traffic", "uncharged", kTiming, kAssumption},
      {"rt.prefetch.enabled", "false", kBoth},
      {"rt.prefetch.records", "1", kBoth},
      {"rt.prefetch.queue", "1", kBoth},
      {"rt.prefetch.replayed", "true", kBoth},
      {"rt.box.per_child", "true", kBoth},
      {"rt.box.count", "1", kBoth},
      {"rt.box.latency", "26", kBoth},
      {"rt.box.interval", "4", kBoth},
      {"rt.triangle.count", "1", kBoth},
      {"rt.triangle.latency", "74", kBoth},
      {"rt.triangle.interval", "4", kBoth},
      {"rt.sphere.count", "1", kBoth, "", {}, "sphere"},
      {"rt.sphere.latency", "74", kBoth, "", {}, "sphere"},
      {"rt.sphere.interval", "4", kBoth, "", {}, "sphere"},
      {"rt.gaussian.enabled", "true", kBoth, "", {}, "ellipsoid"},
      {"rt.gaussian.count", "1", kBoth, "", {"rt.gaussian.enabled=true"}, "ellipsoid"},
      {"rt.gaussian.latency", "74", kBoth, "", {"rt.gaussian.enabled=true"}, "ellipsoid"},
      {"rt.gaussian.interval", "4", kBoth, "", {"rt.gaussian.enabled=true"}, "ellipsoid"},
      {"rt.any_hit_unit.enabled", "true", kBoth},
      {"rt.any_hit_unit.latency", "9", kTiming, kFixedTime, {"rt.any_hit_unit.enabled=true"}},
      {"rt.any_hit_unit.level_latency", "9", kTiming, kFixedTime, {"rt.any_hit_unit.enabled=true"}},
      {"rt.any_hit_unit.count", "1", kBoth, "", {"rt.any_hit_unit.enabled=true"}},
      {"rt.any_hit_unit.bound_latency",
       "40",
       kTiming,
       kFixedTime,
       {"rt.any_hit_unit.enabled=true", "rt.gaussian.enabled=true"},
       "bounded ellipsoid"},
      {"rt.traversal", "warp", kBoth, "", {}, "walked"},
      {"rt.warp_stack.entries", "10", kBoth, "", {"rt.traversal=warp", "rt.warp_stack.ahead=8"}, "walked"},
      {"rt.warp_stack.ahead", "1", kBoth, "", {"rt.traversal=warp"}, "walked"},
      {"rt.warp_stack.window", "1", kBoth, "", {"rt.traversal=warp"}, "walked"},
      {"rt.warp_stack.write_ports", "0", kTiming, "any number of ports has no price", {"rt.traversal=warp"}, "walked"},
      {"rt.warp_stack.tests", "1", kBoth, "", {"rt.traversal=warp"}, "walked"},
      {"rt.warp_buffer.ray_banks", "1", kBoth},
      {"rt.memory.node_ports", "1", kBoth, "", {"rt.traversal=warp"}, "walked"},
      {"rt.transform.decode_latency", "9", kBoth, "", {}, "quantised ellipsoid"},
      {"rt.transform.count", "1", kBoth},
      {"rt.transform.latency", "8", kBoth},
      {"rt.transform.interval", "64", kBoth},
      {"simt.schedulers", "1", kBoth},
      {"simt.instruction_latency", "8", kTiming, kFixedTime},
      {"simt.sectors_per_cycle", "4", kBoth},
      {"simt.dependent_loads", "false", kTiming, kShader},
      {"simt.k_buffer_layout", "by_ray", kTiming, kTraffic},
      {"simt.eviction_layout", "by_lane", kTiming, kTraffic},
      {"simt.eviction_traffic", "uncharged", kTiming, kAssumption},
      {"simt.list_batch", "2", kTiming, kShader, {}, "list"},
      {"simt.registers", "131072", kCost, "any number serves the fixed count of resident warps"},
      {"simt.registers_per_thread", "255", kBoth, "", {"simt.registers=16384"}},
      {"simt.payload_registers", "200", kBoth, "", {"simt.registers=16384", "simt.registers_per_thread=55"}},
      {"simt.message_latency", "5", kTiming, kFixedTime},
      {"simt.cost.raygen_prologue", "80", kTiming, kShader},
      {"simt.cost.trace_call", "12", kTiming, kShader},
      {"simt.cost.evict_move_fixed", "16", kTiming, kShader},
      {"simt.cost.evict_move_per_entry", "8", kTiming, kShader},
      {"simt.cost.any_hit_fixed", "24", kTiming, kShader},
      {"simt.cost.any_hit_per_shift", "6", kTiming, kShader},
      {"simt.cost.any_hit_bound", "40", kTiming, kShader, {}, "bounded"},
      {"simt.cost.call_fixed", "50", kTiming, kShader},
      {"simt.cost.call_per_lane", "5", kTiming, kShader},
      {"simt.cost.intersection_fixed", "56", kTiming, kShader, {}, "box"},
      {"simt.cost.intersection_transform", "48", kTiming, kShader, {}, "box"},
      {"simt.cost.sort_per_entry", "12", kTiming, kShader, {}, "single"},
      {"simt.cost.list_per_entry", "80", kTiming, kShader, {}, "list"},
      {"simt.cost.list_exchange", "50", kTiming, kShader, {}, "list"},
      {"simt.cost.blend_fixed", "20", kTiming, kShader},
      {"simt.cost.blend_with_alpha",
       "20",
       kTiming,
       kShader,
       {"rt.any_hit_unit.enabled=true", "rt.gaussian.enabled=true"},
       "ellipsoid"},
      {"simt.cost.blend_per_entry", "48", kTiming, kShader},
      {"simt.cost.sh_per_coefficient", "8", kTiming, kShader},
      {"simt.cost.epilogue", "20", kTiming, kShader},
      {"simt.cost.node_fetch", "48", kTiming, kShader, {"rt.memory.by_shader=true"}},
      {"l1.bytes", "2048", kBoth},
      {"l1.line_bytes", "256", kBoth},
      {"l1.ways", "4", kBoth},
      {"l1.replacement", "fifo", kBoth},
      {"l1.latency", "40", kTiming, kFixedTime},
      {"l1.tag_latency", "3", kTiming, kFixedTime},
      {"l1.banks", "1", kBoth},
      {"l1.mshr_entries", "4", kBoth},
      {"l1.mshr_merges", "1", kBoth},
      {"l1.miss_queue", "1", kBoth},
      {"l1.rotating_priority", "false", kTiming, kPolicy},
      {"l1.private_writes", "write_back", kBoth},
      {"l1.private_allocate", "true", kTiming, kPolicy},
      {"l1.write_back_buffer",
       "1",
       kBoth,
       "",
       {"l1.private_writes=write_back", "l1.private_allocate=true", "l1.bytes=2048"}},
      {"l1.perfect", "true", kTiming, kLimitStudy},
      {"l1.link_latency", "3", kTiming, kFixedTime},
      {"l1.link_capacity", "1", kBoth},
      {"crossbar.latency", "16", kBoth},
      {"crossbar.output_buffer", "1", kBoth, "", {"gpu.sms=8", "l2.slices=1", "crossbar.link_capacity=1"}},
      {"crossbar.link_latency", "3", kTiming, kFixedTime},
      {"crossbar.link_capacity", "1", kBoth},
      {"l2.bytes", "16384", kBoth},
      {"l2.slices", "4", kBoth},
      {"l2.interleave_bytes", "512", kTiming, kPolicy},
      {"l2.xor_hash", "true", kTiming, kPolicy},
      {"l2.line_bytes", "256", kBoth},
      {"l2.ways", "4", kBoth},
      {"l2.replacement", "fifo", kBoth},
      {"l2.latency", "330", kTiming, kFixedTime},
      {"l2.queue", "1", kBoth, "", {"gpu.sms=8", "l2.slices=1", "l2.mshr_entries=2"}},
      {"l2.mshr_entries", "2", kBoth},
      {"l2.mshr_merges", "1", kBoth},
      {"l2.reply_queue", "4", kBoth},
      {"l2.dram_queue", "4", kBoth},
      {"l2.perfect", "true", kTiming, kLimitStudy},
      {"dram.mhz", "2800", kTiming, kClock},
      {"dram.bandwidth_gb_s", "50", kTiming, kClock},
      {"dram.channels", "1", kBoth},
      {"dram.banks", "2", kBoth},
      {"dram.bank_groups", "4", kTiming, kDramChip, {"dram.timing.ccd_l=8"}},
      {"dram.group_bytes", "32", kTiming, kDramChip, {"dram.bank_groups=4"}},
      {"dram.row_bytes", "128", kTiming, kDramChip},
      {"dram.burst_bytes", "16", kBoth},
      {"dram.queue", "4", kBoth},
      {"dram.scheduling", "fcfs", kTiming, kPolicy},
      {"dram.hit_cap", "1", kBoth, "", {"dram.scheduling=fr_fcfs_cap", "dram.mhz=250"}},
      {"dram.age_cap", "1", kTiming, kPolicy},
      {"dram.bank_xor", "true", kTiming, kPolicy},
      {"dram.fixed_latency", "512", kTiming, kFixedTime},
      {"dram.perfect", "true", kTiming, kLimitStudy},
      {"dram.timing.ccd", "8", kTiming, kDramChip},
      {"dram.timing.rrd", "20", kTiming, kDramChip},
      {"dram.timing.rcd", "40", kTiming, kDramChip},
      {"dram.timing.ras", "100", kTiming, kDramChip},
      {"dram.timing.rp", "40", kTiming, kDramChip},
      {"dram.timing.rc", "124", kTiming, kDramChip},
      {"dram.timing.cl", "40", kTiming, kDramChip},
      {"dram.timing.wl", "16", kTiming, kDramChip},
      {"dram.timing.cdlr", "36", kTiming, kDramChip},
      {"dram.timing.wr", "40", kTiming, kDramChip},
      {"dram.timing.rtp", "40", kTiming, kDramChip},
      {"dram.timing.turn", "8", kTiming, kDramChip},
      {"dram.timing.ccd_l", "8", kTiming, kDramChip},
      {"dram.timing.rrd_l", "40", kTiming, kDramChip},
      {"dram.timing.cdlr_l", "60", kTiming, kDramChip},
      {"dram.timing.rcd_wr", "60", kTiming, kDramChip},
      {"dram.timing.faw", "100", kTiming, kDramChip},
      {"dram.timing.refi", "1000", kTiming, kDramChip},
      {"dram.timing.rfc", "300", kTiming, kDramChip, {"dram.timing.refi=1000"}}};
  return all;
}

/// What a simulation says of one machine, and what the cost model builds from the same settings.
struct Seen {
  ordered_json statistics;  ///< counts and times: without energy, which is the cost model's
  std::string inventory;    ///< every storage and operator of every module
  double energy = 0.0;      ///< as the simulation reported it
  double priced = 0.0;      ///< the run's counts at the prices of the cost model's own machine
};

std::string text_of(const std::vector<modules::Inventory>& inventories) {
  std::string text;
  for (const modules::Inventory& module : inventories) {
    text += module.module + "\n";
    for (const modules::Storage& s : module.storage) {
      text += fmt::format("  {} {} {} {} {} {}\n", s.name, static_cast<int>(s.kind), s.bits, s.read_ports,
                          s.write_ports, s.word_bits);
    }
    for (const modules::Operators& o : module.operators) text += fmt::format("  {} {} {}\n", o.name, o.width, o.count);
  }
  return text;
}

class OneParameter : public ::testing::TestWithParam<const char*> {
 protected:
  const std::string& trace(const std::string& kind) {
    auto& file = files_[kind];
    if (file == nullptr) {
      file = std::make_unique<traces::testing::TemporaryFile>("one_parameter_" + kind);
      traces::testing::RandomOptions random{.seed = 11, .groups = 8, .warp_size = 32};
      const auto tracing = from_name<traces::Tracing>(kind).value_or(traces::Tracing::multi);
      const bool ellipsoid = kind.ends_with("ellipsoid");
      random.two_level = tracing == traces::Tracing::multi && !ellipsoid && kind != "box" && kind != "walked";
      random.blas_root_is_leaf = kind == "sphere";
      random.checkpoint = tracing == traces::Tracing::multi && kind != "walked";
      random.tracing = tracing;
      if (kind == "walked") random.depth = 5;  // deep enough to fill a warp's stack
      if (kind == "bins") random.bins = 4;
      if (kind.starts_with("quantised")) random.layout = traces::NodeLayout::quantised, random.procedural = true;
      auto made = traces::testing::random_trace(random);
      if (kind == "sphere") made.header.accel = traces::AccelKind::tlas_sphere;
      if (kind.starts_with("bounded")) made.header.opacity_bound = traces::OpacityBound::on;
      if (ellipsoid || kind == "box" || kind == "walked") sim::test::make_procedural(made, kind == "box");
      for (traces::RayGroup& group : made.groups) group.kind = traces::RayKind::primary;
      traces::testing::write_trace(file->path(), made.header, made.groups);
    }
    return file->path();
  }

  Seen see(const std::string& kind, const std::vector<std::string>& settings) {
    const std::string path = trace(kind);
    const std::string file = grtx::paths::source_dir() + "/configs/small.toml";
    ChildProcess simulation("simulation", [&] {
      return sim::test::simulate_priced(path, sim::load_config(file, settings), {}).document.at("stats").dump();
    });
    const ordered_json stats = ordered_json::parse(simulation.result());
    ChildProcess cost("cost", [&] {
      const sim::GpuConfig config = sim::load_config(file, settings);
      const bool one_level = kind == "single" || kind == "list" || kind == "walked";
      const bool ellipsoid = kind.ends_with("ellipsoid");
      const bool monolithic = ellipsoid || kind == "box";
      sim::MachineUse use{one_level ? "baseline" : monolithic ? "hw" : "grtx"};
      use.peak = true;  // as RtUnit takes these traces, which do not say
      if (kind.starts_with("bounded")) use.opacity_bound = traces::OpacityBound::on;
      if (kind == "sphere" || ellipsoid || kind == "walked") use.leaves = sim::LeafTest::spheres;
      if (kind == "box") use.leaves = sim::LeafTest::boxes;
      if (kind.starts_with("quantised")) use.layout = traces::NodeLayout::quantised;
      if (kind == "bins") use.checkpoint_bins = 4, use.checkpoint_capacity = traces::testing::RandomOptions().capacity;
      const std::vector<modules::Inventory> inventories = sim::machine_inventory(config, use);
      const auto value = [&](const std::string& name) {
        return stats.contains(name) ? stats.at(name).at("value").get<double>() : 0.0;
      };
      const ordered_json seen = {{"inventory", text_of(inventories)},
                                 {"energy", total(run_energy(value, config, inventories, {}, {})).central}};
      return seen.dump();
    });
    const ordered_json priced = ordered_json::parse(cost.result());
    Seen seen;
    for (const auto& [name, entry] : stats.items()) {
      if (!name.starts_with("host.") && !name.starts_with("gpu.energy")) seen.statistics[name] = entry.at("value");
    }
    seen.inventory = priced.at("inventory");
    seen.energy = stats.at("gpu.energy_nj").at("value");
    seen.priced = priced.at("energy");
    return seen;
  }

  const Seen& base(const Mutation& m) {
    const auto key = std::pair(std::string(m.trace), m.given);
    if (!bases_.contains(key)) bases_[key] = see(m.trace, m.given);
    return bases_.at(key);
  }

  std::map<std::string, std::unique_ptr<traces::testing::TemporaryFile>> files_;
  std::map<std::pair<std::string, std::vector<std::string>>, Seen> bases_;
};

TEST_P(OneParameter, MovesSimulatorAndCostAsClassified) {
  for (const Mutation& m : mutations()) {
    if (!std::string(m.key).starts_with(GetParam())) continue;
    const Seen& before = base(m);
    std::vector<std::string> settings = m.given;
    settings.push_back(std::string(m.key) + "=" + m.value);
    const Seen after = see(m.trace, settings);
    const bool timing = before.statistics.at("gpu.cycles") != after.statistics.at("gpu.cycles") ||
                        before.statistics.at("gpu.time_us") != after.statistics.at("gpu.time_us");
    EXPECT_EQ(timing, m.moves != Moves::cost) << m.key << ": the simulated time";
    EXPECT_EQ(before.inventory != after.inventory, m.moves != Moves::timing)
        << m.key << ": what the machine is made of";
    // Both halves were built from one configuration: the run's own energy is that at the cost model's prices, but for
    // whole picojoules per part.
    EXPECT_NEAR(after.energy, after.priced, 0.01) << m.key;
    EXPECT_NEAR(before.energy, before.priced, 0.01) << m.key;
  }
}

/// Beginnings of keys: the rows of each are a test.
constexpr const char* kGroups[] = {"gpu.", "rt.warp_b", "rt.warp_s", "rt.s",  "rt.m", "rt.a",      "rt.c", "rt.p",
                                   "rt.b", "rt.g",      "rt.t",      "simt.", "l1.",  "crossbar.", "l2.",  "dram."};

INSTANTIATE_TEST_SUITE_P(Tables, OneParameter, ::testing::ValuesIn(kGroups), [](const auto& table) {
  std::string name = table.param;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

TEST(OneParameterTable, EveryKeyIsClassifiedOnceAndWithAReasonWhenOnlyOneMoves) {
  sim::GpuConfig config;
  std::set<std::string> keys, classified;
  for (const modules::Parameter& key : sim::config_keys(config)) {
    const auto* const names = std::get_if<modules::Choice>(&key.value);
    if (names != nullptr && names->names.size() == 1) continue;  // until a program registers more
    if (key.name.ends_with(".implementation")) continue;         // two ways to simulate the same hardware
    keys.insert(key.name);
  }
  for (const Mutation& m : mutations()) {
    EXPECT_TRUE(classified.insert(m.key).second) << m.key << " is there twice";
    const auto begins = [&](const char* group) { return std::string(m.key).starts_with(group); };
    EXPECT_EQ(std::count_if(std::begin(kGroups), std::end(kGroups), begins), 1) << m.key << " must be in one group";
    EXPECT_EQ(std::string(m.why).empty(), m.moves == Moves::both) << m.key;
  }
  EXPECT_EQ(keys, classified);
}

}  // namespace
}  // namespace grtx::explore
