// The table of configuration keys: one line a parameter.
#include <limits>

#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {
namespace {

constexpr Confidence kPaper = Confidence::paper;
constexpr Confidence kPublic = Confidence::public_source;
constexpr Confidence kAssumed = Confidence::assumption;

const char* const kTable1 = "GRTX, Table I";
const char* const kVulkanSim = "Vulkan-Sim (SM75_RTX2060 configuration)";
const char* const kGpgpuSim = "GPGPU-Sim as in Vulkan-Sim";
const char* const kTta = "UBC 2024, generalized tree traversal accelerator";
const char* const kOurs = "this project";
const char* const kCounted = "this project: operations of Listing 1 counted";

constexpr double kMaxLatency = 100000;
constexpr double kMaxEntries = 65536;

void add_gpu(std::vector<ConfigKey>& keys, GpuConfig& c) {
  keys.insert(
      keys.end(),
      {{"gpu.sms", &c.sms, 1, 256, "SMs", "streaming multiprocessors", kTable1, kPaper},
       {"gpu.core_mhz", &c.core_mhz, 1, 100000, "MHz", "clock of SMs, crossbar and L2", kTable1, kPaper},
       {"gpu.resident_warps", &c.resident_warps, 1, 64, "warps", "warp slots of an SM", kVulkanSim, kPublic},
       {"gpu.rt_units", &c.rt_units, 1, 16, "units", "RT units of an SM; its warp slots take turns", kTable1, kPaper}});
}

void add_rt(std::vector<ConfigKey>& keys, modules::RtUnitConfig& c) {
  keys.insert(
      keys.end(),
      {{"rt.warp_buffer.entries", &c.warp_buffer.entries, 1, 64, "warps", "warp buffer of the RT unit", kTable1,
        kPaper},
       {"rt.warp_buffer.stack_entries", &c.warp_buffer.stack_entries, 1, 1024, "entries",
        "traversal stack of a lane in the warp buffer; deeper ones spill, or cost nothing without spill", kOurs,
        kAssumed},
       {"rt.warp_buffer.spill", &c.warp_buffer.spill, 0, 0, "",
        "stack entries beyond the warp buffer are written to memory and read back",
        "Vulkan-Sim: the stack costs nothing", kPublic},
       {"rt.scheduler.policy",
        choice(c.scheduler.policy, {{"oldest_first", "oldest_first"},
                                    {"round_robin", "round_robin"},
                                    {"greedy_then_oldest", "greedy_then_oldest"}}),
        0, 0, "", "which warp is served in a cycle", kVulkanSim, kPublic},
       {"rt.memory.queue", &c.memory.queue, 32, kMaxEntries, "fetches", "node fetches waiting to be issued", kOurs,
        kAssumed},
       {"rt.memory.merge_in_flight", &c.memory.merge_in_flight, 0, 0, "",
        "a fetch also merges with one of its warp that is still under way", "Vulkan-Sim merges within one cycle only",
        kPublic},
       {"rt.memory.by_shader", &c.memory.by_shader, 0, 0, "",
        "the SIMT core reads the nodes, the RT unit only intersects (as on AMD)", "GRTX, Section IV: the RT unit does",
        kPaper},
       {"rt.memory.instance_leaf_bytes", &c.memory.traffic.instance_leaf_bytes, 64, 128, "B",
        "bytes read of an instance leaf, 64 or 128", "Vulkan-Sim reads all 128", kPublic},
       {"rt.memory.blas_header_read", &c.memory.traffic.blas_header_read, 0, 0, "",
        "entering a BLAS also reads its 64 B header", "Vulkan-Sim", kPublic},
       {"rt.memory.leaf_descriptor_read", &c.memory.traffic.leaf_descriptor_read, 0, 0, "",
        "a primitive leaf's 8 B descriptor is a request of its own",
        "Vulkan-Sim does; off because it is part of the leaf", kAssumed},
       {"rt.any_hit.timeout", &c.any_hit.timeout, 0, 1e9, "cycles",
        "an any-hit batch is sent this long after its first lane began to wait", kOurs, kAssumed},
       {"rt.checkpoint.lanes", &c.checkpoint.lanes, 1, 64, "entries/cycle",
        "checkpoint entries taken from lanes in a cycle", kOurs, kAssumed},
       {"rt.checkpoint.write_queue", &c.checkpoint.write_queue, 2, kMaxEntries, "sectors",
        "checkpoint sectors waiting to be written", kOurs, kAssumed},
       {"rt.checkpoint.write_combine", &c.checkpoint.write_combine, 0, 0, "",
        "a lane's entries gather in its open sector before they are written", kOurs, kAssumed},
       {"rt.checkpoint.read_buffer", &c.checkpoint.read_buffer, 0, 0, "", "a lane keeps the last sector it replayed",
        kOurs, kAssumed},
       {"rt.prefetch.enabled", &c.sibling_prefetch, 0, 0, "", "sibling prefetcher", "GRTX, Section V", kPaper},
       {"rt.prefetch.records", &c.prefetcher.records, 1, 8, "nodes", "internal visits remembered a lane", kOurs,
        kAssumed},
       {"rt.prefetch.queue", &c.prefetcher.queue, 1, kMaxEntries, "nodes", "prefetches waiting to be issued", kOurs,
        kAssumed},
       {"rt.box.per_child", &c.box_op_per_child, 0, 0, "", "a box operation tests one child instead of a whole node",
        "UBC 2024 and Arches test a whole node, Vortex one child", kPublic}});
  const auto add_unit = [&](const std::string& name, modules::IntersectionUnit::Config& unit, const std::string& what,
                            const char* source, Confidence confidence) {
    keys.push_back({"rt." + name + ".count", &unit.count, 1, 1024, "pipelines", what + " pipelines of an RT unit",
                    source, confidence});
    keys.push_back({"rt." + name + ".latency", &unit.latency, 1, kMaxLatency, "cycles", "from start to result", source,
                    confidence});
    keys.push_back({"rt." + name + ".interval", &unit.interval, 1, kMaxLatency, "cycles",
                    "between two starts of a pipeline", source, confidence});
  };
  add_unit("box", c.ray_box, "ray-box", kTta, kPublic);
  add_unit("triangle", c.ray_triangle, "ray-triangle", kTta, kPublic);
  add_unit("sphere", c.ray_sphere, "ray-sphere", "this project: as the ray-triangle unit", kAssumed);
  add_unit("transform", c.ray_transform, "ray-transform", kTta, kPublic);
}

void add_simt(std::vector<ConfigKey>& keys, GpuConfig& config) {
  modules::SimtCoreConfig& c = config.simt;
  keys.insert(keys.end(),
              {{"simt.schedulers", &c.schedulers, 1, 64, "schedulers", "warp schedulers of an SM", kTable1, kPaper},
               {"simt.instruction_latency", &c.instruction_latency, 0, kMaxLatency, "cycles",
                "from issue of an instruction to its result", "common GPU ALU latency", kAssumed},
               {"simt.registers", &c.registers, 1, 1e9, "registers", "32-bit registers of an SM, for the hardware cost",
                kVulkanSim, kPublic},
               {"simt.message_latency", &config.sm_links.message_latency, 1, kMaxLatency, "cycles",
                "of messages between SIMT core and RT unit", kOurs, kAssumed}});
  struct Cost {
    const char* name;
    unsigned* value;
    const char* description;
  };
  modules::ShaderCosts& costs = c.costs;
  for (const Cost& cost : {Cost{"raygen_prologue", &costs.raygen_prologue, "pixel to ray, payload and offsets cleared"},
                           Cost{"trace_call", &costs.trace_call, "operands of a traceRay call to the RT unit"},
                           Cost{"evict_move_fixed", &costs.evict_move_fixed, "eviction buffer to k-buffer: set-up"},
                           Cost{"evict_move_per_entry", &costs.evict_move_per_entry, "the same, per entry"},
                           Cost{"any_hit_fixed", &costs.any_hit_fixed, "any-hit shader without insertion"},
                           Cost{"any_hit_per_shift", &costs.any_hit_per_shift, "per k-buffer entry moved"},
                           Cost{"sort_per_entry", &costs.sort_per_entry, "single-round: an entry in a merge pass"},
                           Cost{"blend_fixed", &costs.blend_fixed, "blending: set-up and termination test"},
                           Cost{"blend_per_entry", &costs.blend_per_entry, "response, alpha and transmittance"},
                           Cost{"sh_per_coefficient", &costs.sh_per_coefficient, "basis value, three colour channels"},
                           Cost{"epilogue", &costs.epilogue, "pixel address and colour"}}) {
    keys.push_back({std::string("simt.cost.") + cost.name, cost.value, 0, 1e6, "instructions", cost.description,
                    kCounted, kAssumed});
  }
  keys.push_back({"simt.cost.node_fetch", &costs.node_fetch, 0, 1e6, "instructions",
                  "a traversal step of a warp, when shaders fetch nodes", "this project: a traversal loop counted",
                  kAssumed});
}

void add_l1(std::vector<ConfigKey>& keys, GpuConfig& config) {
  modules::L1Cache::Config& c = config.l1;
  keys.insert(
      keys.end(),
      {{"l1.bytes", &c.geometry.bytes, 32, 1e9, "B", "size of the L1 data cache", kTable1, kPaper},
       {"l1.line_bytes", &c.geometry.line_bytes, 32, 256, "B", "line; sectors are 32 B", kTable1, kPaper},
       {"l1.ways", &c.geometry.ways, 1, kMaxEntries, "ways", "associativity, LRU", kTable1, kPaper},
       {"l1.latency", &c.latency, 1, kMaxLatency, "cycles", "from request to response of a hit", kTable1, kPaper},
       {"l1.tag_latency", &c.tag_latency, 1, kMaxLatency, "cycles", "from request to a miss leaving the cache", kOurs,
        kAssumed},
       {"l1.banks", &c.banks, 1, 64, "banks", "sector-interleaved banks, one access a cycle each", kVulkanSim, kPublic},
       {"l1.mshr_entries", &c.mshr_entries, 1, kMaxEntries, "sectors", "sectors outstanding", kVulkanSim, kPublic},
       {"l1.mshr_merges", &c.mshr_merges, 1, kMaxEntries, "requests", "requests of an MSHR, the first included",
        kVulkanSim, kPublic},
       {"l1.miss_queue", &c.miss_queue, 1, kMaxEntries, "requests", "misses and writes waiting for the crossbar",
        kVulkanSim, kPublic},
       {"l1.rotating_priority", &c.rotating_priority, 0, 0, "",
        "rotating priority of the clients; else node fetches first", kOurs, kAssumed},
       {"l1.perfect", &c.perfect, 0, 0, "", "every access hits (limit study)", kOurs, kAssumed},
       {"l1.link_latency", &config.sm_links.l1_latency, 1, kMaxLatency, "cycles",
        "of the links to and from the L1; the way back is part of l1.latency", kOurs, kAssumed},
       {"l1.link_capacity", &config.sm_links.l1_capacity, 1, kMaxEntries, "requests", "waiting at a port of the L1",
        kOurs, kAssumed}});
}

void add_memory(std::vector<ConfigKey>& keys, GpuConfig& config) {
  modules::Crossbar::Config& x = config.crossbar;
  modules::L2Slice::Config& c = config.l2;
  keys.insert(
      keys.end(),
      {{"crossbar.latency", &x.latency, 1, kMaxLatency, "cycles", "unloaded, each way", kOurs, kAssumed},
       {"crossbar.output_buffer", &x.output_buffer, 1, kMaxEntries, "packets", "waiting at an output", kGpgpuSim,
        kPublic},
       {"crossbar.link_latency", &config.links.latency, 1, kMaxLatency, "cycles",
        "of the links between SM, crossbar and L2; part of crossbar.latency at its outputs", kOurs, kAssumed},
       {"crossbar.link_capacity", &config.links.capacity, 1, kMaxEntries, "packets", "of the same links", kOurs,
        kAssumed},
       {"l2.bytes", &config.l2_bytes, 32, 1e12, "B", "size of the L2, all slices", kTable1, kPaper},
       {"l2.slices", &config.interleave.slices, 1, 256, "slices", "L2 slices = DRAM channels",
        "this project: 4 x 28 GB/s; the paper gives no count", kAssumed},
       {"l2.interleave_bytes", &config.interleave.bytes, 128, 1e9, "B", "consecutive bytes of one slice", kGpgpuSim,
        kPublic},
       {"l2.xor_hash", &config.interleave.xor_hash, 0, 0, "", "higher address bits are folded into the slice number",
        kOurs, kAssumed},
       {"l2.line_bytes", &c.geometry.line_bytes, 32, 256, "B", "line; sectors are 32 B", kTable1, kPaper},
       {"l2.ways", &c.geometry.ways, 1, kMaxEntries, "ways", "associativity, LRU", kTable1, kPaper},
       {"l2.latency", &c.latency, 1, kMaxLatency, "cycles",
        "from request at the slice to the reply of a hit; misses pay it too", kTable1, kPaper},
       {"l2.queue", &c.queue, 1, kMaxEntries, "requests", "accesses waiting at the tags", kVulkanSim, kPublic},
       {"l2.mshr_entries", &c.mshr_entries, 1, kMaxEntries, "sectors", "sectors outstanding of a slice", kVulkanSim,
        kPublic},
       {"l2.mshr_merges", &c.mshr_merges, 1, kMaxEntries, "requests", "requests of an MSHR, the first included",
        kVulkanSim, kPublic},
       {"l2.reply_queue", &c.reply_queue, 1, kMaxEntries, "replies", "waiting for the crossbar", kVulkanSim, kPublic},
       {"l2.dram_queue", &c.dram_queue, 1, kMaxEntries, "requests", "reads and write-backs waiting for DRAM",
        kVulkanSim, kPublic},
       {"l2.perfect", &c.perfect, 0, 0, "", "every access hits (limit study)", kOurs, kAssumed}});
}

void add_fast(std::vector<ConfigKey>& keys, FastModel& c) {
  keys.push_back({"fast.stride", &c.stride, 0, FastModel::kLargestStride, "events",
                  "fast mode: one in so many of a lane's events takes time, a power of two; 0: by the trace's size",
                  kOurs, kAssumed});
  keys.push_back(
      {"fast.seed", &c.seed, 0, 4294967295.0, "", "fast mode: which of a lane's events take time", kOurs, kAssumed});
}

/// Offered where a program has registered memory systems that are configured by a file.
void add_dram_simulator(std::vector<ConfigKey>& keys, DramSimulatorConfig& c) {
  if (memory_systems_with_file().empty()) return;
  keys.insert(
      keys.end(),
      {{"dram.simulator.config", Choice{{}, [&c] { return c.file; }, [&c](const std::string& file) { c.file = file; }},
        0, 0, "", "the DRAM simulator's own configuration file", kOurs, kAssumed},
       {"dram.simulator.per_slice", &c.per_slice, 0, 0, "",
        "a memory for each slice with local addresses, else one for all with global ones", kOurs, kAssumed}});
}

void add_dram(std::vector<ConfigKey>& keys, GpuConfig& config) {
  modules::Dram::Config& c = config.dram;
  modules::DramChannelConfig& channel = c.channel;
  keys.insert(
      keys.end(),
      {{"dram.model",
        Choice{memory_system_names(), [&config] { return config.dram_model; },
               [&config](const std::string& name) { config.dram_model = name; },
               "dramsys and ramulator need a build with GRTX_DRAMSYS or GRTX_RAMULATOR (docs/guide/dram-backends.md)"},
        0, 0, "", "what stands behind the memory sockets; programs may register more (docs/model/tlm.md)", kOurs,
        kAssumed},
       {"dram.mhz", &config.memory_mhz, 1, 100000, "MHz", "memory (command) clock", kTable1, kPaper},
       {"dram.banks", &channel.banks, 1, 64, "banks", "of a channel", kVulkanSim, kPublic},
       {"dram.row_bytes", &channel.row_bytes, 32, 1e6, "B", "row of a bank", kVulkanSim, kPublic},
       {"dram.burst_bytes", &channel.burst_bytes, 1, 4096, "B", "moved by one column command", kVulkanSim, kPublic},
       {"dram.queue", &channel.queue, 4, kMaxEntries, "bursts", "of a channel", kVulkanSim, kPublic},
       {"dram.age_cap", &channel.age_cap, 0, 1e12, "clocks", "after which nothing may overtake a request", kOurs,
        kAssumed},
       {"dram.bank_xor", &channel.bank_xor, 0, 0, "", "low row bits are folded into the bank number", kOurs, kAssumed},
       {"dram.fixed_latency", &c.fixed_latency, 0, 1e9, "clocks", "added to every response (100 core cycles = 73 ns)",
        kVulkanSim, kPublic},
       {"dram.perfect", &c.perfect, 0, 0, "", "every request takes fixed_latency only (limit study)", kOurs,
        kAssumed}});
  struct Timing {
    const char* name;
    unsigned* value;
    const char* description;
  };
  modules::DramTiming& t = channel.timing;
  for (const Timing& timing :
       {Timing{"ccd", &t.ccd, "column command to column command, clocks of a burst"},
        Timing{"rrd", &t.rrd, "activate to activate, other banks"}, Timing{"rcd", &t.rcd, "activate to column command"},
        Timing{"ras", &t.ras, "activate to precharge"}, Timing{"rp", &t.rp, "precharge to activate"},
        Timing{"rc", &t.rc, "activate to activate, same bank"}, Timing{"cl", &t.cl, "read command to data"},
        Timing{"wl", &t.wl, "write command to data"}, Timing{"cdlr", &t.cdlr, "write data to read command"},
        Timing{"wr", &t.wr, "write data to precharge"}, Timing{"rtp", &t.rtp, "read command to precharge"},
        Timing{"turn", &t.turn, "bubble between read and write data"}}) {
    const double min = std::string(timing.name) == "ccd" ? 1 : 0;
    keys.push_back({std::string("dram.timing.") + timing.name, timing.value, min, 10000, "clocks", timing.description,
                    kVulkanSim, kPublic});
  }
  add_dram_simulator(keys, config.dram_simulator);
}

}  // namespace

std::vector<ConfigKey> config_keys(GpuConfig& config) {
  std::vector<ConfigKey> keys;
  add_gpu(keys, config);
  add_rt(keys, config.rt);
  add_simt(keys, config);
  add_l1(keys, config);
  add_memory(keys, config);
  add_dram(keys, config);
  add_fast(keys, config.fast);
  return keys;
}

}  // namespace grtx::sim
