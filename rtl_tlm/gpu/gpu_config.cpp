// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/gpu/gpu_config.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/base/json.h"
#include "grtx/modules/simt/decide/work_distribution.h"
#include "grtx/rtl_tlm/gpu/config_trial.h"

namespace grtx::sim {
namespace {

std::string table_of(const std::string& key) { return key.substr(0, key.rfind('.')); }

/// Text inside a Markdown table cell.
std::string cell(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '|') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

/// Bytes that the data buses of all channels move in a memory clock.
double bytes_a_clock(const GpuConfig& c) {
  return static_cast<double>(c.interleave.dram_channels()) * c.dram.channel.burst_bytes / c.dram.channel.timing.ccd;
}

/// The memory clock that gives dram.bandwidth_gb_s, MHz.
double clock_of_bandwidth(const GpuConfig& c) { return 1e3 * c.dram_gb_s / bytes_a_clock(c); }

/// Rules for keys of several units.
void add_rules(const GpuConfig& c, modules::ParameterList& list) {
  using namespace modules;
  list.rule(
      "gpu.rt_units", [&c] { return c.rt_units <= c.resident(); },
      "must not be more than gpu.resident_warps, or than the warps whose registers an SM holds");
  list.rule(
      "rt.memory.l1_hit_latency", [&c] { return !c.rt.memory.asks_at_once() || c.rt_units == 1; },
      "needs gpu.rt_units = 1: the L1 answers one RT unit in the cycle of its request");
  list.rule(
      "l1.latency", [&c] { return c.l1.latency >= c.sm_links.l1_latency; }, "must not be shorter than l1.link_latency");
  list.rule(
      "crossbar.latency", [&c] { return c.crossbar.latency >= c.links.latency; },
      "must not be shorter than crossbar.link_latency");
  list.rule(
      "dram.bandwidth_gb_s", [&c] { return c.dram_gb_s == 0.0 || c.dram_model == kBuiltInMemory; },
      "is of the built-in DRAM, but dram.model is another, whose own file says its bandwidth");
  list.rule(
      "dram.bandwidth_gb_s",
      [&c] { return c.dram_gb_s == 0.0 || (clock_of_bandwidth(c) >= kMinMhz && clock_of_bandwidth(c) <= kMaxMhz); },
      "gives a memory clock outside 100 to 10000 MHz: the bandwidth of all channels times dram.timing.ccd over "
      "dram.burst_bytes and the channels (dram.channels, else l2.slices)");
  const auto by_file = [&c] {
    const std::vector<std::string> with_file = memory_systems_with_file();
    return std::find(with_file.begin(), with_file.end(), c.dram_model) != with_file.end();
  };
  list.rule(
      "dram.simulator.config", [&c, by_file] { return !by_file() || !c.dram_simulator.file.empty(); },
      "names no file, but dram.model needs one");
  list.rule(
      "dram.perfect", [&c, by_file] { return !by_file() || !c.dram.perfect; },
      "is a limit study of the built-in DRAM, but dram.model is another");
}

}  // namespace

void GpuConfig::parameters(modules::ParameterList& list) {
  using namespace modules;
  list.under("gpu", [&](ParameterList& keys) {
    keys.add("sms", sms, {1, 256}, "SMs", "streaming multiprocessors", kTable1);
    keys.add("core_mhz", core_mhz, {kMinMhz, kMaxMhz}, "MHz", "clock of SMs, crossbar and L2", kTable1);
    keys.add("resident_warps", resident_warps, {1, modules::kMostResidentWarps}, "warps", "warp slots of an SM",
             kVulkanSim);
    keys.add("distribution", distribution, modules::work_distribution_names(),
             "policy that chooses the SM of the next ray group", kOurs);
    keys.add("rt_units", rt_units, {1, 16}, "units", "RT units of an SM; its warp slots take turns", kTable1);
  });
  list.part("rt", rt);
  list.part("simt", simt);
  list.under("simt", [&](ParameterList& keys) { sm_links.message_parameters(keys); });
  list.part("simt.cost", simt.costs);
  list.part("l1", l1);
  list.under("l1", [&](ParameterList& keys) { sm_links.l1_parameters(keys); });
  list.part("crossbar", crossbar);
  list.part("crossbar", links);
  list.under("l2", [&](ParameterList& keys) {
    keys.add("bytes", l2_bytes, {32, 1 << 30}, "B", "size of the L2, all slices", kTable1);
  });
  list.part("l2", interleave);
  list.part("l2", l2);
  list.under("dram", [&](ParameterList& keys) {
    keys.add("model", dram_model, memory_system_names(),
             "memory system behind the memory sockets; programs may register more (docs/model/tlm.md)", kOurs,
             "dramsys and ramulator need a build with GRTX_DRAMSYS or GRTX_RAMULATOR (docs/guide/dram-backends.md)");
    keys.add("mhz", memory_mhz, {kMinMhz, kMaxMhz}, "MHz", "memory (command) clock, of all channels", kTable1);
    keys.add("bandwidth_gb_s", dram_gb_s, {0, 1e6}, "GB/s",
             "peak of all channels of the GPU together; sets the memory clock, and times keep their nanoseconds; 0: as "
             "dram.mhz gives it",
             kOurs);
    interleave.channel_parameters(keys);
  });
  list.part("dram", dram);
  // Exists only if the program has registered a memory system that is configured by a file.
  if (!memory_systems_with_file().empty()) list.part("dram.simulator", dram_simulator);
  own.parameters(list);
  add_rules(*this, list);
}

std::vector<modules::Parameter> config_keys(GpuConfig& config) {
  modules::ParameterList list;
  config.parameters(list);
  return list.items();
}

SmConfig GpuConfig::sm(unsigned index) const { return {index, rt_units, resident(), simt, rt, l1, sm_links, own}; }

modules::CrossbarConfig GpuConfig::crossbar_config() const {
  modules::CrossbarConfig config = crossbar;
  config.sms = sms;
  config.interleave = interleave;
  return config;
}

modules::L2SliceConfig GpuConfig::l2_slice(unsigned slice) const {
  modules::L2SliceConfig config = l2;
  config.slice = slice;
  config.interleave = interleave;
  config.geometry.bytes = l2_bytes / interleave.slices;
  return config;
}

modules::DramConfig GpuConfig::dram_config(std::uint64_t bytes) const {
  modules::DramConfig config = dram;
  config.interleave = interleave;
  config.bytes = bytes;
  return config;
}

GpuConfig GpuConfig::at_bandwidth() const {
  GpuConfig same = *this;
  same.dram_gb_s = 0.0;
  if (dram_gb_s == 0.0) return same;
  same.memory_mhz = clock_of_bandwidth(*this);
  const double faster = same.memory_mhz / memory_mhz;
  const auto keep_time = [faster](auto& clocks) {
    clocks = static_cast<std::decay_t<decltype(clocks)>>(std::ceil(static_cast<double>(clocks) * faster - 1e-9));
  };
  modules::DramTiming& t = same.dram.channel.timing;
  for (unsigned* clocks : {&t.rrd, &t.rrd_l, &t.rcd, &t.rcd_wr, &t.ras, &t.rp, &t.rc, &t.cl, &t.wl, &t.cdlr, &t.cdlr_l,
                           &t.wr, &t.rtp, &t.faw, &t.refi, &t.rfc}) {
    keep_time(*clocks);
  }
  keep_time(same.dram.fixed_latency);
  keep_time(same.dram.channel.age_cap);
  return same;
}

double GpuConfig::peak_dram_gb_s() const {
  return dram_gb_s != 0.0 ? dram_gb_s : 1e-3 * memory_mhz * bytes_a_clock(*this);
}

void check_config(const GpuConfig& config, const std::string& origin) { ConfigTrial(config).check(origin); }

LoadedConfig load_machine(const ConfigSource& source, bool check) {
  LoadedConfig loaded;
  const std::vector<modules::Parameter> keys = config_keys(loaded.config);
  ConfigLayers layers(keys);
  const std::string design = "--design " + source.design;
  if (!source.machine.empty()) layers.machine(source.machine);
  loaded.machine_hash = config_hash(loaded.config);
  if (!source.file.empty()) layers.file(source.file);
  GpuConfig undesigned = loaded.config;
  if (!source.design_keys.empty()) layers.design(design, source.design_keys);
  if (!source.settings.empty()) layers.settings(source.settings);
  layers.require_agreement();
  for (const std::string& setting : source.settings) apply_setting(setting, config_keys(undesigned));
  loaded.undesigned_hash = config_hash(undesigned);
  if (check) {
    check_config(loaded.config, !source.settings.empty()      ? "configuration"
                                : !source.design_keys.empty() ? design
                                : source.file.empty()         ? source.machine
                                                              : source.file);
  }
  loaded.tracer = layers.tracer();
  loaded.places = layers.places();
  loaded.rivals = layers.rivals();
  loaded.files = layers.files();
  return loaded;
}

GpuConfig load_config(const std::string& path, const std::vector<std::string>& settings) {
  return load_machine({.file = path, .settings = settings}).config;
}

GpuConfig load_config(GpuConfig config, const std::string& origin, const std::string& path,
                      const std::vector<std::string>& settings) {
  const std::vector<modules::Parameter> keys = config_keys(config);
  ConfigLayers layers(keys);
  if (!path.empty()) layers.file(path);
  layers.settings(settings);
  layers.require_agreement();
  check_config(config, !settings.empty() ? "configuration" : path.empty() ? origin : path);
  return config;
}

nlohmann::ordered_json config_json(const GpuConfig& config) {
  GpuConfig copy = config;  // keys point to mutable values
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const modules::Parameter& key : config_keys(copy)) json[key.name] = value_json(key);
  return json;
}

std::string config_hash(const GpuConfig& config) { return hex(xxh3(json_text(config_json(config)))); }

std::string config_reference() {
  GpuConfig defaults;
  std::string text;
  std::string table;
  for (const modules::Parameter& key : config_keys(defaults)) {
    if (const std::string t = table_of(key.name); t != table) {
      table = t;
      text += fmt::format(
          "{}### [{}]\n\n| key | default | range | unit | meaning | source of the default | confidence |\n"
          "|---|---|---|---|---|---|---|\n",
          text.empty() ? "" : "\n", table);
    }
    text +=
        fmt::format("| `{}` | {} | {} | {} | {} | {} | {} |\n", key.name, value_text(key), range_text(key), key.unit,
                    cell(key.description), cell(key.origin.source), static_cast<char>(key.origin.confidence));
  }
  return text;
}

}  // namespace grtx::sim
