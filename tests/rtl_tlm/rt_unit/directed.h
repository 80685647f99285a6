// SPDX-License-Identifier: Apache-2.0
// Small hand-written traces through the whole GPU, and the times of the steps that they are made of. One SM, one warp
// slot, core and memory clock alike, so that the arithmetic stays on one page. Cycles count from the launch of a warp.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "grtx/base/child_process.h"
#include "grtx/rtl_tlm/run/simulation.h"
#include "grtx/traces/check.h"
#include "grtx/traces/reader.h"
#include "grtx/traces/writer.h"
#include "rtl_tlm/rt_unit/rt_bench.h"
#include "rtl_tlm/simulate_priced.h"
#include "traces/temporary_file.h"

namespace grtx::sim::test {

using nlohmann::ordered_json;
using traces::RayGroup;

// Defaults of the model (docs/model/configuration.md).
inline constexpr Cycle kMessage = 1, kLink = 1, kTag = 1, kL1 = 20, kCrossbar = 8, kL2 = 165;
inline constexpr Cycle kBox = 13, kTriangle = 37, kTransform = 6, kPrologue = 40, kTraceCall = 6, kEvictMove = 8,
                       kAnyHit = 12;
inline constexpr Cycle kBlendFixed = 10, kBlendEntry = 24, kShCoefficient = 4, kEpilogue = 10;
inline constexpr Cycle kCcd = 4, kRcd = 20, kCl = 20, kDramFixed = 256;
inline constexpr Cycle kNodeSectors = 2;  // 64 B

/// A shader phase that begins in cycle c with its loads there is ready in c + phase(n): one cycle to its scheduler, n
/// instructions, 4 cycles to the last result.
inline constexpr Cycle phase(Cycle instructions) { return 1 + instructions + 4; }

/// From a request's issue until its response is visible.
inline constexpr Cycle kL1Hit = kLink + kL1;
inline constexpr Cycle kToL2 = kLink + kTag + kLink + kCrossbar;  // port, tags, link to the crossbar, crossbar
inline constexpr Cycle kFromL2 = kLink + kCrossbar + kLink;       // link to the crossbar, crossbar, port
inline constexpr Cycle kL2Hit = kToL2 + kL2 + kFromL2;            // 187
/// To the next memory edge, the DRAM, to the next core edge.
inline constexpr Cycle dram(Cycle clocks) { return kToL2 + kL2 + 1 + clocks + kDramFixed + 1 + kFromL2; }
inline constexpr Cycle kRowMiss = dram(kRcd + kCl + kCcd);
inline constexpr Cycle kRowHit = dram(kCl + kCcd);

/// One visit, from the scheduling of the lane to the next: docs/model/rt_scheduler.md, S + M + 1 + L.
inline constexpr Cycle visit(Cycle memory, Cycle unit) { return kNodeSectors + memory + 1 + unit; }
/// From DRAM the second sector follows the first by a burst: the socket takes one request in two cycles, the data bus
/// one in CCD = 4 clocks.
inline constexpr Cycle dram_visit(Cycle memory, Cycle unit) { return 1 + memory + kCcd + 1 + unit; }

/// From the launch to the first scheduling in the RT unit: link, prologue, traceRay, link, accepted, scheduled.
inline constexpr Cycle kStart = kMessage + phase(kPrologue) + phase(kTraceCall) + kMessage + 1;  // 59
/// From retirement to the end of a ray that blends nothing and whose pixels are `sectors` stores: link, blending,
/// epilogue, one store per cycle, the last acknowledged after `store` cycles, link to the distributor.
inline constexpr Cycle finish(Cycle sectors, Cycle store) {
  return kMessage + phase(kBlendFixed) + phase(kEpilogue) + (sectors - 1) + store + kMessage;
}

/// Pixels of 32 lanes are 512 B.
inline constexpr Cycle kWarpPixels = 16;

struct Directed {
  traces::Header header;
  std::vector<RayGroup> groups;
};

inline Directed directed(unsigned k, unsigned lanes, std::uint64_t checkpoint_capacity = 0) {
  Directed d;
  d.header = small_header("tri20", checkpoint_capacity);
  d.header.k = k;
  d.header.width = 32;
  d.header.height = 1;
  d.header.warp_mapping = traces::WarpMapping::linear;
  d.groups.resize(1);
  d.groups[0].rays.resize(lanes);
  for (unsigned lane = 0; lane < lanes; ++lane) d.groups[0].rays[lane].pixel = lane;
  return d;
}

/// A node at `unit` (of 64 B) whose children follow one another from `child`.
inline traces::NodeDefinition node(std::uint32_t unit, std::uint32_t child, unsigned children, NodeKind kind) {
  return node_definition(unit, child, std::vector<NodeKind>(children, kind));
}

/// Adds a chain of `length` internal nodes at units 1, 2, ... that ends in a leaf, and returns its events.
inline std::vector<Event> chain(RayGroup& group, unsigned length, LeafOutcome outcome) {
  std::vector<Event> events;
  for (unsigned i = 0; i < length; ++i) {
    group.nodes.push_back(node(1 + i, 2 + i, 1, i + 1 == length ? NodeKind::triangle : NodeKind::internal));
    events.push_back(internal_event(i, 0b1));
  }
  events.push_back(leaf_event(1 + length, outcome));
  return events;
}

/// What the trace says of the last round of a ray.
inline void end_round(traces::Ray& ray, unsigned k_count, const std::vector<std::uint32_t>& gaussians,
                      bool terminated) {
  ray.rounds.back().k_count = static_cast<std::uint16_t>(k_count);
  ray.rounds.back().processed_count = static_cast<std::uint16_t>(gaussians.size());
  ray.rounds.back().terminated = terminated;
  for (const std::uint32_t gaussian : gaussians) {
    traces::Processed entry{.gaussian = gaussian & 0x7FFFFFFFU, .blended = 1};
    ray.processed.push_back(entry);
  }
}

/// Writes the trace, proves it consistent, simulates it and returns the statistics.
inline ordered_json simulated(const Directed& d, const std::vector<std::string>& more = {}) {
  const traces::testing::TemporaryFile file("directed");
  traces::Header header = d.header;
  header.groups = d.groups.size();
  traces::Writer writer(file.path(), header);
  for (std::uint32_t i = 0; i < d.groups.size(); ++i) {
    RayGroup group = d.groups[i];
    group.index = i;
    writer.append(group);
  }
  writer.finish();
  traces::check(traces::Reader(file.path()), true);
  std::vector<std::string> settings = {"gpu.sms=1",       "gpu.resident_warps=1", "gpu.core_mhz=1000",
                                       "dram.mhz=1000",   "l2.slices=1",          "rt.prefetch.enabled=false",
                                       "rt.box.count=32", "rt.triangle.count=32", "rt.checkpoint.traffic=charged"};
  settings.insert(settings.end(), more.begin(), more.end());
  ChildProcess child("simulation", [&] {
    const SimulationResult result = test::simulate_priced(file.path(), load_config("", settings), {});
    EXPECT_EQ(result.violations, std::vector<std::string>{});
    return result.violations.empty() ? result.document.at("stats").dump() : std::string("{}");
  });
  return ordered_json::parse(child.result());
}

inline std::uint64_t value(const ordered_json& stats, const char* name) {
  return stats.at(name).at("value").get<std::uint64_t>();
}

inline const std::vector<std::string> kPerfectL1 = {"l1.perfect=true"};

}  // namespace grtx::sim::test
