#include "grtx/rtl_tlm/gpu/memory_system.h"

#include <fmt/format.h>

#include <utility>

#include "grtx/base/error.h"
#include "grtx/rtl_tlm/gpu/built_in_memory.h"

namespace grtx::sim {
namespace {

struct Registered {
  std::string name;
  MemorySystemFactory factory;
  bool needs_file = false;
};

/// The one table of names that configuration keys are checked against.
std::vector<Registered>& registered() {
  static std::vector<Registered> all = {{kBuiltInMemory, build_built_in_memory}};
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
  list.add(prefix + ".reads", all.reads, "requests", "read requests");
  list.add(prefix + ".writes", all.writes, "requests", "write requests");
  list.add(prefix + ".bytes", all.bytes, "B", "bytes read and written");
  list.add(prefix + ".responses", all.responses, "requests", "responses begun");
  for (unsigned i = 0; i < channels(); ++i) {
    list.add(fmt::format("{}.channel{}.bytes", prefix, i), traffic(i).bytes, "B", "bytes read and written");
  }
}

void register_memory_system(const std::string& name, MemorySystemFactory factory, bool needs_file) {
  for (const Registered& known : registered()) {
    if (known.name == name) throw Error("dram.model", name, "is registered already");
  }
  registered().push_back({name, std::move(factory), needs_file});
}

std::vector<std::string> memory_system_names() {
  std::vector<std::string> names;
  for (const Registered& known : registered()) names.push_back(known.name);
  return names;
}

std::vector<std::string> memory_systems_with_file() {
  std::vector<std::string> names;
  for (const Registered& known : registered()) {
    if (known.needs_file) names.push_back(known.name);
  }
  return names;
}

const MemorySystemFactory& memory_system(const std::string& name) {
  std::string names;
  for (const Registered& known : registered()) {
    if (known.name == name) return known.factory;
    names += (names.empty() ? "" : ", ") + known.name;
  }
  throw Error("configuration", "dram.model", fmt::format("must be one of {}, not '{}'", names, name));
}

}  // namespace grtx::sim
