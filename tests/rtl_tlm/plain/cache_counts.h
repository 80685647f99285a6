// SPDX-License-Identifier: Apache-2.0
// What both plain caches count by region: docs/model/l1_cache.md, docs/model/l2_slice.md.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "rtl_tlm/plain/messages.h"
#include "rtl_tlm/plain/statistics.h"

namespace grtx::sim::plain {

struct CacheCounts {
  struct Counts {
    std::uint64_t hits = 0, hits_on_miss = 0, misses = 0, writes = 0, write_hits = 0;
  };
  std::array<Counts, modules::kRegionCount> regions{};
  Counts& operator[](Region region) { return regions[modules::index(region)]; }

  void report(Statistics& s, const std::string& prefix) const {
    for (std::size_t r = 0; r < regions.size(); ++r) {
      const auto region = static_cast<Region>(r);
      report(s, prefix + ".all", regions[r]);
      if (modules::is_node(region)) report(s, prefix + ".node", regions[r]);
      if (modules::is_shader_data(region)) report(s, prefix + ".shader_data", regions[r]);
      report(s, prefix + "." + std::string(name_at<modules::Region>(r)), regions[r]);
    }
  }
  /// Rates, once the counts of all caches are summed.
  static void finish(Statistics& s, const std::string& prefix) {
    const auto rate = [&](const std::string& name) {
      s.values[name + ".hit_rate"] = Statistics::ratio(s[name + ".hits"], s[name + ".reads"]);
    };
    for (const char* group : {".all", ".node", ".shader_data"}) rate(prefix + group);
    for (const std::string& name : names_of<modules::Region>()) rate(prefix + "." + std::string(name));
  }

 private:
  static void report(Statistics& s, const std::string& name, const Counts& c) {
    s.add(name + ".reads", c.hits + c.hits_on_miss + c.misses);
    s.add(name + ".hits", c.hits);
    s.add(name + ".hits_on_miss", c.hits_on_miss);
    s.add(name + ".misses", c.misses);
    s.add(name + ".writes", c.writes);
    s.add(name + ".write_hits", c.write_hits);
  }
};

}  // namespace grtx::sim::plain
