// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/estimate/windows/group_work.h"

#include <algorithm>

#include "grtx/modules/rt_unit/decide/node_visit.h"

namespace grtx::sim {

void WorkCounter::reads(std::uint64_t address, std::uint64_t bytes, const Read& read) {
  for (std::uint64_t sector = address / modules::kSectorBytes; sector * modules::kSectorBytes < address + bytes;
       ++sector) {
    std::uint64_t& seen = seen_[sector * 0x9E3779B97F4A7C15u >> 52];
    if (seen == sector + 1) continue;
    seen = sector + 1;
    distinct_ += 1.0;
    if (read) read(sector * modules::kSectorBytes);
  }
}

GroupWork WorkCounter::count(const traces::RayGroup& group, const modules::MemoryMap& map, const Read& read) {
  GroupWork work;
  seen_.fill(0);
  distinct_ = 0.0;
  std::vector<std::uint32_t> longest;  // by call
  for (const traces::Ray& ray : group.rays) {
    longest.resize(std::max(longest.size(), ray.rounds.size()));
    for (std::size_t r = 0; r < ray.rounds.size(); ++r) longest[r] = std::max(longest[r], ray.rounds[r].event_count);
    for (const traces::Event& event : ray.events) {
      const auto visit = modules::node_visit(event, group, traffic_);
      if (!visit) continue;
      const modules::NodeSectors sectors(*visit, traffic_);
      work.sectors += static_cast<double>(sectors.count());
      for (unsigned i = 0; i < sectors.count(); ++i) reads(map.node(sectors.at(i).address), 1, read);
    }
    for (const traces::Processed& entry : ray.processed) {
      reads(map.gaussian_record(entry.gaussian), map.gaussian_record(1) - map.gaussian_record(0), read);
      reads(map.sh_record(entry.gaussian), map.sh_record(1) - map.sh_record(0), read);
    }
    reads(map.pixel(ray.pixel), modules::MemoryMap::kPixelBytes, read);
  }
  for (const std::uint32_t events : longest) work.steps += events;
  work.calls = static_cast<double>(longest.size());
  work.distinct = distinct_;
  return work;
}

}  // namespace grtx::sim
