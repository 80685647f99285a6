// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/gpu/gpu.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstdlib>
#include <functional>
#include <ostream>
#include <utility>

#include "grtx/base/error.h"
#include "grtx/modules/cache/l2_slice.h"
#include "grtx/modules/kernel/factory.h"
#include "grtx/modules/kernel/link_inventory.h"
#include "grtx/modules/noc/crossbar.h"
#include "grtx/modules/rt_unit/stack/decide/stack_entry.h"
#include "grtx/modules/simt/work_distributor.h"
#include "grtx/rtl_tlm/gpu/construction_order.h"

namespace grtx::sim {

using modules::Link;

namespace {

// SystemC's main() prints a banner before it calls sc_main, unless the environment forbids it: whoever builds a GPU has
// standard output and standard error for himself.
[[maybe_unused]] const int kNoBanner = setenv("SYSTEMC_DISABLE_COPYRIGHT_MESSAGE", "1", 0);

// Entries of a ray's stack area: room for the deepest stack of the widest tree.
constexpr std::uint64_t kStackEntries = std::bit_ceil(modules::deepest_stack(traces::kMaxWidth));

template <typename T>
void add_links(std::vector<std::unique_ptr<Link<T>>>& links, const std::string& name, unsigned count, unsigned latency,
               std::size_t capacity) {
  for (unsigned i = 0; i < count; ++i) {
    links.push_back(std::make_unique<Link<T>>(fmt::format("{}{}", name, i), latency, capacity));
  }
}

/// A stopped kernel cannot be started again; without this check what follows would fail without a reason.
void require_not_stopped(const Gpu& gpu) {
  if ((sc_core::sc_get_status() & (sc_core::SC_STOPPED | sc_core::SC_END_OF_SIMULATION)) == 0) return;
  throw Error("simulation", fmt::format("core cycle {}", gpu.core().edge_at_or_after_now()),
              "a unit has called sc_stop(): only the run itself may end");
}

}  // namespace

modules::MemoryMapConfig memory_map_config(const GpuConfig& config, const traces::Header& header,
                                           std::uint64_t eviction_entries) {
  modules::MemoryMapConfig map{config.sms, config.resident(), 0, 0};
  if (config.rt.warp_buffer.spill) {
    map.stack_sectors = kStackEntries / modules::stack_entry_layout(header.pop_test).in_a_sector;
  }
  map.checkpoint_entry_bytes = config.rt.checkpoint.entry_bytes;
  map.k_buffers = config.simt.k_buffer_layout;
  map.evictions = config.simt.eviction_layout;
  // An eviction buffer has the default capacity, unless the trace needs more.
  const std::uint64_t usual = modules::MemoryMap(header, map).eviction_capacity();
  if (header.checkpoint) map.eviction_capacity = std::max(usual, eviction_entries);
  return map;
}

std::uint64_t memory_bytes(const GpuConfig& config, const traces::Reader& reader) {
  const traces::Header& header = reader.header();
  const std::uint64_t evictions = reader.totals().max_evictions_per_ray;
  return modules::MemoryMap(header, memory_map_config(config, header, evictions)).bytes();
}

Gpu::Gpu(const sc_core::sc_module_name& name, const GpuConfig& config, const traces::Header& header,
         std::uint64_t eviction_entries, modules::GroupSource& source, const BuildOptions& build)
    : sc_module(name),
      dram("dram", config.interleave.slices),
      config_(config),
      header_(header),
      map_(header_, memory_map_config(config, header, eviction_entries)),
      memory_bytes_(build.memory_bytes),
      base_(build.base),
      core_("core_clock", config.core_mhz, build.idle_skip),
      sms_(config.sms),
      slices_(config.interleave.slices) {
  const unsigned slices = config.interleave.slices;
  const SmLinks& messages = config.sm_links;
  add_links(launches_, "launch", config.sms, messages.message_latency, config.resident());
  add_links(ends_, "ended", config.sms, messages.message_latency, config.resident());
  add_links(sm_requests_, "sm_request", config.sms, config.links.latency, config.links.capacity);
  add_links(sm_responses_, "sm_response", config.sms, config.links.latency, config.links.capacity);
  add_links(slice_requests_, "slice_request", slices, config.links.latency, config.links.capacity);
  add_links(slice_responses_, "slice_response", slices, config.links.latency, config.links.capacity);
  build_units(source, build);
  bind_links();
}

void Gpu::build_units(modules::GroupSource& source, const BuildOptions& build) {
  const GpuConfig& config = config_;
  const GpuParts parts = with_registered_parts(build.parts, config_);
  std::vector<std::function<void()>> builders;
  builders.push_back([&] {
    const modules::WorkDistributorConfig work{config.sms, config.resident(), config.distribution};
    distributor_ = modules::made<modules::WorkDistributor>(parts.work_distributor, "work_distributor", "distributor",
                                                           core_, work, source);
  });
  for (unsigned i = 0; i < config.sms; ++i) {
    builders.push_back([&, i] {
      const std::uint64_t order = build.construction_order == 0 ? 0 : build.construction_order + i + 1;
      sms_[i] =
          std::make_unique<Sm>(fmt::format("sm{}", i).c_str(), config.sm(i), header_, map_, core_, order, parts.sm);
    });
  }
  builders.push_back([&] {
    crossbar_ =
        modules::made<modules::Crossbar>(parts.crossbar, "crossbar", "crossbar", config.crossbar_config(), core_);
  });
  for (unsigned i = 0; i < config.interleave.slices; ++i) {
    builders.push_back([&, i] {
      const std::string name_of = fmt::format("l2_slice{}", i);
      modules::L2SliceConfig slice = config.l2_slice(i);
      slice.keep_data = build.keep_data;
      slice.base = build.base;
      slices_[i] = modules::made<modules::L2Slice>(parts.l2_slice, "l2_slice", name_of.c_str(), slice, core_);
    });
  }
  construct(std::move(builders), build.construction_order);
}

void Gpu::bind_links() {
  for (unsigned i = 0; i < config_.sms; ++i) {
    distributor_->launch[i].bind(*launches_[i]);
    distributor_->ended[i].bind(*ends_[i]);
    sms_[i]->launch.bind(*launches_[i]);
    sms_[i]->ended.bind(*ends_[i]);
    sms_[i]->to_memory.bind(*sm_requests_[i]);
    sms_[i]->from_memory.bind(*sm_responses_[i]);
    crossbar_->request_in[i].bind(*sm_requests_[i]);
    crossbar_->response_out[i].bind(*sm_responses_[i]);
  }
  for (unsigned i = 0; i < config_.interleave.slices; ++i) {
    crossbar_->request_out[i].bind(*slice_requests_[i]);
    crossbar_->response_in[i].bind(*slice_responses_[i]);
    slices_[i]->request.bind(*slice_requests_[i]);
    slices_[i]->response.bind(*slice_responses_[i]);
    slices_[i]->memory_socket().bind(dram[i]);
  }
}

void Gpu::restart(const traces::Header& header, std::uint64_t eviction_entries, modules::Caches caches) {
  assert(same_hardware(header, header_));
  header_ = header;
  map_ = modules::MemoryMap(header_, memory_map_config(config_, header_, eviction_entries));
  // The core domain restarts the links of consumers with an alarm; a unit of a user's may have none.
  const auto restart_link = [](auto& link) { link.restart(); };
  for_each_link(restart_link);
  for (const auto& sm : sms_) sm->for_each_link(restart_link);
  core_.restart(caches);
}

void Gpu::save(StateWriter& state) const {
  assert(idle());
  for (const auto& sm : sms_) std::as_const(*sm).l1().save(state);
  for (const auto& slice : slices_) slice->save(state);
}

void Gpu::load(StateReader& state) {
  for (const auto& sm : sms_) sm->l1().load(state);
  for (const auto& slice : slices_) slice->load(state);
}

std::string hardware_of(const traces::Header& h) {
  const unsigned levels = h.three_level() ? 3 : h.two_level ? 2 : 1;
  return fmt::format(
      "accel {}, {}, k {}, checkpoint {} {} {} bins {}, pop test {}, warps of {}, layout {}, {} levels {} wide{}{}",
      name_of(h.accel), name_of(h.tracing), h.k, h.checkpoint ? "on" : "off", name_of(h.checkpoint_order),
      h.checkpoint_capacity, h.checkpoint_bins, name_of(h.pop_test), h.warp_size, name_of(h.layout), levels,
      h.bvh_width, h.opacity_bound == traces::OpacityBound::on ? ", bounded by opacity" : "",
      h.colour == traces::ColourPer::frame ? ", colours once in a frame" : "");
}

std::string addressed_scene(const traces::Header& header) {
  std::string scene;
  const auto add = [&](const auto& input) {
    scene += fmt::format("{}{} {}", scene.empty() ? "" : ", ", input.first, input.second);
  };
  for (const auto& input : header.inputs) {
    const std::string& name = input.first;
    // Not scene_hash: it includes where the objects stand, and they may have moved from frame to frame.
    if (header.three_level() ? name.starts_with("object_hash.") : name == "scene_hash") add(input);
  }
  if (scene.empty()) return "";
  for (const char* const built : {"kernel_radius", "kernel_degree", "instance_bounds", "box_bits"}) {
    if (const auto input = header.inputs.find(built); input != header.inputs.end()) add(*input);
  }
  return scene;
}

bool same_hardware(const traces::Header& a, const traces::Header& b) { return hardware_of(a) == hardware_of(b); }

PauseAtEnd::PauseAtEnd(const sc_core::sc_module_name& name, const Gpu& gpu) : sc_module(name) {
  SC_METHOD(pause);
  sensitive << gpu.distributor().done();
  dont_initialize();
}

bool Gpu::idle() const {
  bool idle = distributor_->idle() && crossbar_->idle();
  for_each_link([&](const auto& link) { idle = idle && link.empty(); });
  for (const auto& sm : sms_) idle = idle && sm->idle();
  for (const auto& slice : slices_) idle = idle && slice->idle();
  return idle;
}

std::uint64_t Gpu::progress() const {
  std::uint64_t sum = 0;
  for_each_link([&](const auto& link) { sum += link.pushed(); });
  for (const auto& sm : sms_) sum += sm->progress();
  return sum;
}

std::vector<modules::Inventory> Gpu::inventory() const {
  std::vector<modules::Inventory> parts;
  parts.push_back(distributor_->inventory());
  for (const auto& sm : sms_) {
    for (modules::Inventory& part : sm->inventory()) parts.push_back(std::move(part));
  }
  parts.push_back(crossbar_->inventory());
  for (const auto& slice : slices_) parts.push_back(slice->inventory());
  modules::Inventory links{std::string(name()) + ".links", {}, {}};
  for (const auto& [what, entries] :
       {std::pair("requests", modules::total_capacity(sm_requests_) + modules::total_capacity(slice_requests_)),
        std::pair("responses", modules::total_capacity(sm_responses_) + modules::total_capacity(slice_responses_))}) {
    links.storage.push_back(
        {what, modules::StorageKind::flip_flop, entries * modules::kPacketBits, 1, 1, false, modules::kPacketBits});
  }
  parts.push_back(std::move(links));
  return parts;
}

void Gpu::dump_state(std::ostream& out) const {
  out << "core cycle " << core_.cycle() << '\n';
  distributor_->dump_state(out);
  for (const auto& sm : sms_) sm->dump_state(out);
  crossbar_->dump_state(out);
  for (const auto& slice : slices_) slice->dump_state(out);
  for_each_link([&](const auto& link) { modules::dump_link(out, link); });
}

void run_for(Gpu& gpu, Cycle cycles) {
  const auto length = sc_core::sc_time::from_value(cycles * gpu.core().period_value());
  gpu.core().allow_ahead((sc_core::sc_time_stamp() + length).value());
  sc_core::sc_start(length, sc_core::SC_RUN_TO_TIME);
  require_not_stopped(gpu);
  // If PauseAtEnd paused it while the clocks were ahead, the kernel catches up.
  gpu.core().allow_ahead(0);
  const sc_core::sc_time ahead = gpu.core().ahead_of_kernel();
  if (ahead != sc_core::SC_ZERO_TIME) sc_core::sc_start(ahead, sc_core::SC_RUN_TO_TIME);
  require_not_stopped(gpu);
}

}  // namespace grtx::sim
