// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/machine_keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>

#include "grtx/experiment/machine.h"
#include "grtx/explore/sweep/designs.h"
#include "grtx/rtl_tlm/gpu/machine_use.h"
#include "grtx/rtl_tlm/gpu/unset_key.h"

namespace grtx::experiment {
namespace {

void put_place(MachineKey& key, const sim::KeyPlaces& places) {
  const auto place = places.find(key.name);
  if (place == places.end()) return;
  const sim::KeyPlace& at = place->second;
  key.from = at.line == 0 ? at.file : fmt::format("{}:{}", std::filesystem::path(at.file).filename().string(), at.line);
  key.source = at.comment;
  key.confidence.clear();
}

/// Rate of the unit that tests the leaves of a design, which has no other; without one that of triangles.
MachineFigure leaf_tests(const modules::RtUnitConfig& rt, const std::string& design,
                         const std::function<double(const modules::IntersectionConfig&)>& rate) {
  const auto figure = [&](const std::string& leaf, const modules::IntersectionConfig& unit) {
    return MachineFigure{leaf + " tests", rate(unit), "G/s", "gpu.sms, gpu.rt_units, rt." + leaf + ", gpu.core_mhz"};
  };
  const bool triangles =
      design.empty() || sim::leaf_test_of(explore::design_of(design).accel) == sim::LeafTest::triangles;
  if (triangles) return figure("triangle", rt.ray_triangle);
  return rt.gaussian_unit ? figure("gaussian", rt.ray_gaussian) : figure("sphere", rt.ray_sphere);
}

std::vector<MachineFigure> figures_of(const sim::GpuConfig& c, const std::string& design) {
  constexpr double kSector = modules::kSectorBytes;
  const double ghz = 1e-3 * c.core_mhz, rt_units = static_cast<double>(c.sms) * c.rt_units;
  const auto tests = [&](const modules::IntersectionConfig& unit) {
    return rt_units * unit.count / unit.interval * ghz;
  };
  std::vector<MachineFigure> figures = {
      {"warps per SM", static_cast<double>(c.resident()), "warps", "gpu.resident_warps, simt.registers"},
      {"rays in flight", 32.0 * c.sms * c.resident(), "rays", "gpu.sms, and the warps of an SM"},
      {"L1 bandwidth", c.sms * c.l1.banks * kSector * ghz, "GB/s", "gpu.sms, l1.banks, gpu.core_mhz"},
      {"node bandwidth", rt_units * c.rt.memory.sectors_per_cycle * kSector * ghz, "GB/s",
       "gpu.sms, gpu.rt_units, rt.memory.sectors_per_cycle, gpu.core_mhz"},
      {"L2 bandwidth", c.interleave.slices * kSector * ghz, "GB/s", "l2.slices, gpu.core_mhz"},
      {"L2 of a slice", 1e-6 * static_cast<double>(c.l2_bytes) / c.interleave.slices, "MB", "l2.bytes, l2.slices"},
      {"box tests", tests(c.rt.ray_box), "G/s", "gpu.sms, gpu.rt_units, rt.box, gpu.core_mhz"},
      leaf_tests(c.rt, design, tests)};
  if (c.dram_model != sim::kBuiltInMemory) return figures;
  const sim::GpuConfig real = c.at_bandwidth();
  const modules::DramTiming& t = real.dram.channel.timing;
  const double clocks = static_cast<double>(t.rcd) + t.cl + t.ccd + static_cast<double>(real.dram.fixed_latency);
  figures.push_back({"DRAM bandwidth", c.peak_dram_gb_s(), "GB/s",
                     "dram.bandwidth_gb_s, else dram.mhz, dram.timing.ccd, dram.burst_bytes, and dram.channels or "
                     "l2.slices"});
  figures.push_back({"DRAM clock", real.memory_mhz, "MHz", "dram.bandwidth_gb_s or dram.mhz"});
  figures.push_back({"DRAM read, row closed", 1e3 * clocks / real.memory_mhz, "ns",
                     "dram.timing.rcd, cl and ccd, dram.fixed_latency, and the clock"});
  return figures;
}

}  // namespace

MachineKeys machine_keys(const MachineChoice& choice) {
  ChosenMachine chosen = choose_machine(choice);
  std::map<std::string, std::string> tracer = chosen.tracer;
  if (!choice.design.empty()) tracer = explore::tracer_of(explore::design_of(choice.design), tracer, {});
  MachineKeys all;
  for (const modules::Parameter& parameter : sim::config_keys(chosen.config)) {
    MachineKey key{parameter.name,
                   sim::value_json(parameter),
                   true,
                   parameter.unit,
                   "default",
                   parameter.origin.source,
                   std::string(1, static_cast<char>(parameter.origin.confidence))};
    key.set = sim::is_set(parameter);
    put_place(key, chosen.places);
    all.keys.push_back(std::move(key));
  }
  for (const auto& [name, value] : tracer) {
    MachineKey key{"tracer." + name, value, true, "", "", "", ""};
    const auto own = chosen.tracer.find(name);
    if (own != chosen.tracer.end() && own->second == value) {
      put_place(key, chosen.places);
    } else {
      key.from = "--design " + choice.design;
    }
    all.keys.push_back(std::move(key));
  }
  all.figures = figures_of(chosen.config, choice.design);
  return all;
}

}  // namespace grtx::experiment
