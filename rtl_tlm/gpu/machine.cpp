// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/gpu/machine.h"

#include <stdexcept>
#include <utility>

#include "grtx/traces/node_layout.h"

namespace grtx::sim {
namespace {

class NoGroups final : public modules::GroupSource {
 public:
  std::uint64_t count() const override { return 0; }
  const traces::RayGroup* acquire(std::uint64_t) override { throw std::logic_error("there are no groups"); }
  void release(std::uint64_t) override {}
};

traces::Header header_of(const MachineUse& use) {
  using traces::AccelKind;
  traces::Header header;
  header.two_level = use.design == "sw" || use.design == "grtx";
  header.checkpoint = use.design == "hw" || use.design == "grtx";
  switch (use.leaves) {
    case LeafTest::triangles:
      header.accel = header.two_level ? AccelKind::tlas_tri20 : AccelKind::tri20;
      break;
    case LeafTest::spheres:
      header.accel = header.two_level ? AccelKind::tlas_sphere : AccelKind::ellipsoid;
      break;
    case LeafTest::boxes:
      header.accel = header.two_level ? AccelKind::tlas_box : AccelKind::box;
      break;
  }
  header.pop_test = use.pop_test;
  header.opacity_bound = use.opacity_bound;
  header.any_hit = use.any_hit;
  header.inputs["sort_key"] = use.peak ? "peak" : "entry";
  header.checkpoint_capacity = header.checkpoint ? use.checkpoint_capacity : 0;
  header.checkpoint_bins = header.checkpoint ? use.checkpoint_bins : 0;
  header.layout = use.layout;
  header.bvh_width = use.width();
  // The smallest possible node image: its size is not hardware.
  const std::uint64_t unit = header.node_sizes().unit();
  header.root = unit;
  header.node_image_bytes = 64 * unit;
  if (header.two_level) {
    header.blas_base = 32 * unit;
    header.blas_root = 33 * unit;
    header.blas_bytes = 32 * unit;
    if (use.objects) {
      header.scene_leaves = {{2 * unit, 0}};
      header.object_roots = {17 * unit};
    }
  }
  header.gaussians = 1;
  header.k = 1;  // not hardware: the private store has its own size
  return header;
}

}  // namespace

std::vector<modules::Inventory> inventory_of(const Gpu& gpu, const MemorySystem& memory) {
  std::vector<modules::Inventory> all = gpu.inventory();
  if (std::optional<modules::Inventory> controllers = memory.inventory()) {
    all.push_back(std::move(*controllers));
    all.back().module = "gpu.dram_controllers";
  }
  return all;
}

IdleMachine::IdleMachine(const GpuConfig& config, const traces::Header& header, std::uint64_t eviction_entries)
    : none_(std::make_unique<NoGroups>()),
      gpu_(std::make_unique<Gpu>("gpu", config, header, eviction_entries, *none_, BuildOptions{})),
      memory_(make_memory({}, *gpu_, {})) {}

IdleMachine::~IdleMachine() = default;

std::vector<modules::Inventory> IdleMachine::inventory() const { return inventory_of(*gpu_, *memory_); }

std::vector<modules::Inventory> machine_inventory(const GpuConfig& config, const MachineUse& use) {
  if (sc_core::sc_get_status() != sc_core::SC_ELABORATION) {
    throw std::logic_error("a process can elaborate once only");
  }
  modules::set_time_resolution_to_fs();
  const traces::Header header = header_of(use);
  return IdleMachine(config, header, 0).inventory();
}

}  // namespace grtx::sim
