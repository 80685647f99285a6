#include "grtx/rtl_tlm/gpu/gpu_config.h"

#include <fmt/format.h>

#include <algorithm>

#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/modules/rtl/rtl_units.h"
#include "grtx/rtl_tlm/config/config_file.h"

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

/// Memory of the host for tables that a machine can make large: each alone is in its range, but they multiply.
struct HostTable {
  const char* key;
  double bytes;
};
constexpr double kMostHostBytes = 2e9;

double tag_bytes(const modules::SectorCacheTags::Geometry& cache) {
  const double line = 44.0, small_set = 128.0;
  return static_cast<double>(cache.sets()) * (cache.ways > 16 ? line * cache.ways : small_set);
}

double mshr_bytes(double entries, double merges) { return entries * (48.0 + 8.0 * merges); }

HostTable largest_table(const GpuConfig& c) {
  const double sms = c.sms, slices = c.interleave.slices;
  const HostTable tables[] = {{"l1.bytes", sms * tag_bytes(c.l1.geometry)},
                              {"l1.mshr_entries", sms * mshr_bytes(c.l1.mshr_entries, c.l1.mshr_merges)},
                              {"l2.bytes", slices * tag_bytes(c.l2_slice(0).geometry)},
                              {"l2.mshr_entries", slices * mshr_bytes(c.l2.mshr_entries, c.l2.mshr_merges)}};
  return *std::max_element(std::begin(tables), std::end(tables),
                           [](const HostTable& a, const HostTable& b) { return a.bytes < b.bytes; });
}

}  // namespace

void GpuConfig::parameters(modules::ParameterList& list) {
  using namespace modules;
  list.under("gpu", [&](ParameterList& keys) {
    keys.add("sms", sms, {1, 256}, "SMs", "streaming multiprocessors", kTable1);
    keys.add("core_mhz", core_mhz, {kMinMhz, kMaxMhz}, "MHz", "clock of SMs, crossbar and L2", kTable1);
    keys.add("resident_warps", resident_warps, {1, 64}, "warps", "warp slots of an SM", kVulkanSim);
    keys.add("rt_units", rt_units, {1, 16}, "units", "RT units of an SM; its warp slots take turns", kTable1);
  });
  list.part("rt", rt);
  list.part("simt", simt);
  list.under("simt", [&](ParameterList& keys) { sm_links.message_parameters(keys); });
  list.part("simt.private_store", simt.private_store);
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
             "what stands behind the memory sockets; programs may register more (docs/model/tlm.md)", kOurs,
             "dramsys and ramulator need a build with GRTX_DRAMSYS or GRTX_RAMULATOR (docs/guide/dram-backends.md)");
    keys.add("mhz", memory_mhz, {kMinMhz, kMaxMhz}, "MHz", "memory (command) clock", kTable1);
    interleave.channel_parameters(keys);
  });
  list.part("dram", dram);
  // Offered where a program has registered memory systems that are configured by a file.
  if (!memory_systems_with_file().empty()) list.part("dram.simulator", dram_simulator);
  list.part("fast", fast);
}

std::vector<modules::Parameter> config_keys(GpuConfig& config) {
  modules::ParameterList list;
  config.parameters(list);
  return list.items();
}

SmConfig GpuConfig::sm(unsigned index) const {
  SmConfig config{index, rt_units, resident_warps, simt, rt, l1, sm_links};
  config.rt.checkpoint.store.warps = (resident_warps + rt_units - 1) / rt_units;
  return config;
}

modules::Crossbar::Config GpuConfig::crossbar_config() const {
  modules::Crossbar::Config config = crossbar;
  config.sms = sms;
  config.interleave = interleave;
  return config;
}

modules::L2Slice::Config GpuConfig::l2_slice(unsigned slice) const {
  modules::L2Slice::Config config = l2;
  config.slice = slice;
  config.interleave = interleave;
  config.geometry.bytes = l2_bytes / interleave.slices;
  return config;
}

modules::Dram::Config GpuConfig::dram_config(std::uint64_t bytes) const {
  modules::Dram::Config config = dram;
  config.interleave = interleave;
  config.bytes = bytes;
  return config;
}

void check_config(const GpuConfig& config, const std::string& origin) {
  const auto require = [&](bool holds, const char* key, const std::string& rule) {
    if (!holds) throw Error(origin, key, rule);
  };
  const auto power_of_two = [](std::uint64_t value) { return value != 0 && (value & (value - 1)) == 0; };
  require(power_of_two(config.l1.geometry.line_bytes), "l1.line_bytes", "must be a power of two");
  require(power_of_two(config.l2.geometry.line_bytes), "l2.line_bytes", "must be a power of two");
  require(config.l1.geometry.sets() >= 1, "l1.bytes", "must hold at least l1.ways lines of l1.line_bytes");
  require(config.l2_slice(0).geometry.sets() >= 1, "l2.bytes",
          "a slice (l2.bytes / l2.slices) must hold at least l2.ways lines of l2.line_bytes");
  const HostTable table = largest_table(config);
  require(table.bytes <= kMostHostBytes, table.key,
          fmt::format("would take {:.1f} GB of the host's memory in all caches together, at most {:.0f}",
                      table.bytes * 1e-9, kMostHostBytes * 1e-9));
  require(config.fast.stride == 0 || power_of_two(config.fast.stride), "fast.stride", "must be 0 or a power of two");
  require(power_of_two(config.interleave.bytes), "l2.interleave_bytes", "must be a power of two");
  require(config.l2.geometry.line_bytes <= config.interleave.bytes, "l2.interleave_bytes",
          "must not be smaller than l2.line_bytes");
  require(!config.interleave.xor_hash || power_of_two(config.interleave.slices), "l2.xor_hash",
          "needs a power of two of l2.slices");
  require(config.interleave.slices % config.interleave.dram_channels() == 0, "dram.channels",
          "must divide l2.slices: each slice belongs to one channel");
  config.dram.channel.check([&](bool holds, const char* key, const char* rule) {
    require(holds, (std::string("dram.") + key).c_str(), rule);
  });
  require(config.l1.latency >= config.sm_links.l1_latency, "l1.latency", "must not be shorter than l1.link_latency");
  require(config.crossbar.latency >= config.links.latency, "crossbar.latency",
          "must not be shorter than crossbar.link_latency");
  require(config.l2.reply_queue >= config.l2.mshr_merges, "l2.reply_queue",
          "must hold the replies of an MSHR (l2.mshr_merges)");
  require(config.l2.dram_queue >= config.l2.geometry.sectors(), "l2.dram_queue",
          "must hold the write-back of a line (l2.line_bytes / 32)");
  require(!config.rt.warp_buffer.spill || config.rt.warp_buffer.stack_entries >= 2, "rt.warp_buffer.stack_entries",
          "must be at least 2 with rt.warp_buffer.spill");
  require(modules::CheckpointConfig::allows_entry_bytes(config.rt.checkpoint.entry_bytes), "rt.checkpoint.entry_bytes",
          modules::CheckpointConfig::kEntryBytesRule);
  require(config.rt.checkpoint.allows_store(), "rt.private_store.checkpoint_entries",
          modules::CheckpointConfig::kStoreRule);
  require(config.rt.checkpoint.allows_traffic(), "rt.checkpoint.traffic",
          std::string(modules::CheckpointConfig::kUnchargedRule) + "; charged takes them");
  const auto width = [&](unsigned sectors, const char* key) {
    require(power_of_two(sectors), key, "must be 1, 2 or 4: a line has four sectors");
  };
  width(config.rt.memory.sectors_per_cycle, "rt.memory.sectors_per_cycle");
  width(config.simt.sectors_per_cycle, "simt.sectors_per_cycle");
  const modules::PrivateStore::Config& store = config.simt.private_store;
  require(power_of_two(store.lane_bytes), "simt.private_store.lane_bytes", "must be 4 or 8");
  require(!store.insertion || store.k_buffer_entries > 0, "simt.private_store.insertion",
          "needs k-buffers on chip: simt.private_store.k_buffer_entries");
  require(config.rt_units <= config.resident_warps, "gpu.rt_units", "must not be more than gpu.resident_warps");
  memory_system(config.dram_model);  // throws for an unknown name
  const std::vector<std::string> with_file = memory_systems_with_file();
  const bool by_file = std::find(with_file.begin(), with_file.end(), config.dram_model) != with_file.end();
  require(!by_file || !config.dram_simulator.file.empty(), "dram.simulator.config",
          "names no file, but dram.model needs one");
  require(!by_file || !config.dram.perfect, "dram.perfect",
          "is a limit study of the built-in DRAM, but dram.model is " + config.dram_model);
  const modules::RtlRefusal refusal = modules::rtl_refusal(config.rt);
  require(*refusal.key == 0, (std::string("rt.") + refusal.key).c_str(), refusal.rule);
  const unsigned leaf = config.rt.memory.traffic.instance_leaf_bytes;
  require(leaf == 64 || leaf == 128, "rt.memory.instance_leaf_bytes", "must be 64 or 128");
}

GpuConfig load_config(const std::string& path, const std::vector<std::string>& settings) {
  return load_config(GpuConfig(), "", path, settings);
}

GpuConfig load_config(GpuConfig config, const std::string& origin, const std::string& path,
                      const std::vector<std::string>& settings) {
  const std::vector<modules::Parameter> keys = config_keys(config);
  if (!path.empty()) load_config_file(path, keys);
  for (const std::string& setting : settings) apply_setting(setting, keys);
  check_config(config, !settings.empty() ? "configuration" : path.empty() ? origin : path);
  return config;
}

nlohmann::ordered_json config_json(const GpuConfig& config) {
  GpuConfig copy = config;  // keys point to mutable values
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const modules::Parameter& key : config_keys(copy)) {
    std::visit(
        [&](const auto& target) {
          if constexpr (std::is_same_v<std::decay_t<decltype(target)>, modules::Choice>) {
            json[key.name] = target.get();
          } else {
            json[key.name] = *target;
          }
        },
        key.value);
  }
  return json;
}

// Keys that came later count where they differ from what was there before, so that hashes on record stay. What was
// there before is their default.
std::string config_hash(const GpuConfig& config) {
  static constexpr const char* kLaterKeys[] = {"dram.model",
                                               "dram.simulator.config",
                                               "dram.simulator.per_slice",
                                               "l1.replacement",
                                               "l2.replacement",
                                               "l1.private_writes",
                                               "l1.private_allocate",
                                               "l1.held_misses",
                                               "rt.memory.sectors_per_cycle",
                                               "simt.sectors_per_cycle",
                                               "simt.k_buffer_layout",
                                               "simt.eviction_layout",
                                               "simt.private_store.k_buffer_entries",
                                               "simt.private_store.eviction_entries",
                                               "simt.private_store.latency",
                                               "simt.private_store.lane_bytes",
                                               "simt.private_store.insertion",
                                               "simt.cost.coin",
                                               "rt.sphere.quadric",
                                               "simt.private_store.insertion_latency",
                                               "dram.scheduling",
                                               "dram.hit_cap",
                                               "rt.checkpoint.entry_bytes",
                                               "rt.checkpoint.traffic",
                                               "simt.eviction_traffic",
                                               "rt.checkpoint.forward",
                                               "rt.checkpoint.read_ahead",
                                               "rt.checkpoint.prefetch_nodes",
                                               "rt.checkpoint.implementation",
                                               "rt.box.implementation",
                                               "rt.transform.implementation",
                                               "rt.private_store.checkpoint_entries",
                                               "rt.private_store.latency",
                                               "rt.private_store.read_ports",
                                               "rt.prefetch.replayed",
                                               "rt.stack_prefetch.depth",
                                               "rt.stack_prefetch.trigger",
                                               "rt.stack_prefetch.pops",
                                               "rt.box.rotate_latency",
                                               "rt.cooperation.ahead",
                                               "dram.channels",
                                               "dram.bank_groups",
                                               "dram.group_bytes",
                                               "dram.timing.ccd_l",
                                               "dram.timing.rrd_l",
                                               "dram.timing.cdlr_l",
                                               "dram.timing.rcd_wr",
                                               "dram.timing.faw",
                                               "dram.timing.refi",
                                               "dram.timing.rfc"};
  nlohmann::ordered_json json = config_json(config);
  const nlohmann::ordered_json before = config_json(GpuConfig());
  for (const char* key : kLaterKeys) {
    if (json.contains(key) && json.at(key) == before.value(key, json.at(key))) json.erase(key);
  }
  // What wrote back before there was this buffer was another machine.
  const char* const buffer = "l1.write_back_buffer";
  if (!json.contains("l1.private_writes") && json.at(buffer) == before.at(buffer)) json.erase(buffer);
  return hex(xxh3(json.dump()));
}

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
