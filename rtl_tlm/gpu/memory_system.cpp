// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/gpu/memory_system.h"

#include <fmt/format.h>

#include <utility>

#include "grtx/base/declare/registry.h"
#include "grtx/modules/kernel/factory.h"
#include "grtx/rtl_tlm/gpu/built_in_memory.h"
#include "grtx/rtl_tlm/gpu/gpu.h"

namespace grtx::sim {
namespace {

struct Registered {
  MemorySystemFactory factory;
  bool needs_file = false;
};

auto& systems() {
  static declare::Registry<Registered> all("memory system", "dram.model", {{kBuiltInMemory, {build_built_in_memory}}});
  return all;
}

}  // namespace

MemoryTraffic MemorySystem::total() const {
  MemoryTraffic sum;
  for (unsigned i = 0; i < channels(); ++i) sum += traffic(i);
  return sum;
}

void MemorySystem::describe_traffic(modules::StatisticList& list, const std::string& prefix) const {
  const MemoryTraffic all = total();
  list.add(prefix + ".reads", all.reads, "requests", "read requests", modules::StatisticKind::count);
  list.add(prefix + ".writes", all.writes, "requests", "write requests", modules::StatisticKind::count);
  list.add(prefix + ".bytes", all.bytes, "B", "bytes read and written", modules::StatisticKind::count);
  list.add(prefix + ".responses", all.responses, "requests", "responses begun", modules::StatisticKind::count);
  for (unsigned i = 0; i < channels(); ++i) {
    list.add(fmt::format("{}.channel{}.bytes", prefix, i), traffic(i).bytes, "B", "bytes read and written",
             modules::StatisticKind::count);
  }
}

void register_memory_system(const std::string& name, MemorySystemFactory factory, bool needs_file) {
  systems().add(name, {std::move(factory), needs_file});
}

std::vector<std::string> memory_system_names() { return systems().names(); }

std::vector<std::string> memory_systems_with_file() {
  std::vector<std::string> names;
  for (const auto& [name, known] : systems().entries()) {
    if (known.needs_file) names.push_back(name);
  }
  return names;
}

const MemorySystemFactory& memory_system(const std::string& name) { return systems().at(name).factory; }

std::unique_ptr<MemorySystem> make_memory(const MemorySystemFactory& own, Gpu& gpu, const BuildOptions& build) {
  const std::string& model = gpu.config().dram_model;
  const MemorySystemFactory& factory = own ? own : memory_system(model);
  return modules::not_null(factory ? factory(gpu, build) : nullptr, own ? "memory" : model.c_str());
}

}  // namespace grtx::sim
