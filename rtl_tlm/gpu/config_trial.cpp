// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/gpu/config_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <utility>

#include "grtx/base/error.h"
#include "grtx/rtl_tlm/config/config_file.h"
#include "grtx/rtl_tlm/rtl/rtl_units.h"

namespace grtx::sim {
namespace {

/// Host memory of a table whose size is a product of keys: each key is in its range, but the product may be too large.
struct HostTable {
  const char* key;
  double bytes;
};
constexpr double kMostHostBytes = 2e9;

double tag_bytes(const modules::CacheGeometry& cache) {
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

/// Throws Error for a size that is not a whole number of sets: the tags would round it down. step: bytes of a set in
/// all caches of this size together; factors: the keys that make it.
void require_whole_sets(const std::string& origin, const char* key, std::uint64_t bytes, std::uint64_t step,
                        const char* factors) {
  if (bytes % step == 0) return;
  const std::uint64_t below = bytes / step * step;
  throw Error(origin, key, fmt::format("must be a multiple of {}, as {} or {}", factors, below, below + step));
}

void require_whole_sets(const GpuConfig& c, const std::string& origin) {
  const auto set = [](const modules::CacheGeometry& g) { return std::uint64_t{g.ways} * g.line_bytes; };
  require_whole_sets(origin, "l1.bytes", c.l1.geometry.bytes, set(c.l1.geometry), "l1.ways x l1.line_bytes");
  require_whole_sets(origin, "l2.bytes", c.l2_bytes, c.interleave.slices * set(c.l2.geometry),
                     "l2.slices x l2.ways x l2.line_bytes");
}

/// While it lives, config.l2 is that of one L2 slice, with the values that the netlist decides filled in.
class AsAssembled {
 public:
  explicit AsAssembled(GpuConfig& config) : config_(config), by_keys_(config.l2) { config.l2 = config.l2_slice(0); }
  ~AsAssembled() { config_.l2 = by_keys_; }
  AsAssembled(const AsAssembled&) = delete;
  AsAssembled& operator=(const AsAssembled&) = delete;

 private:
  GpuConfig& config_;
  modules::L2SliceConfig by_keys_;
};

}  // namespace

ConfigTrial::ConfigTrial(GpuConfig base) : config_(std::move(base)) {
  config_.parameters(list_);
  for (const modules::Parameter& key : keys()) {
    places_[key.name] = base_.size();
    base_.push_back(value_text(key));
  }
}

std::size_t ConfigTrial::set(const std::string& name, const std::string& value) {
  apply_setting(name + "=" + value, keys());
  set_.push_back(places_.at(name));
  return set_.back();
}

void ConfigTrial::reset() {
  for (const std::size_t place : set_) {
    [[maybe_unused]] const std::string broken = assign_text(keys()[place], base_[place]);
    assert(broken.empty());
  }
  set_.clear();
}

// The units check their own rules, with the values that the netlist decides filled in.
void ConfigTrial::check(const std::string& origin) {
  memory_system(config_.dram_model);  // throws for an unknown name
  {
    const AsAssembled filled(config_);
    require_rules(list_, origin);
  }
  require_whole_sets(config_, origin);
  const RtlRefusal refusal = rtl_refusal(config_.rt);
  if (*refusal.key != 0) throw Error(origin, std::string("rt.") + refusal.key, refusal.rule);
  const HostTable table = largest_table(config_);
  if (table.bytes <= kMostHostBytes) return;
  throw Error(origin, table.key,
              fmt::format("would take {:.1f} GB of the host's memory in all caches together, at most {:.0f}",
                          table.bytes * 1e-9, kMostHostBytes * 1e-9));
}

nlohmann::ordered_json value_json(const modules::Parameter& key) {
  return std::visit(
      [](const auto& target) -> nlohmann::ordered_json {
        if constexpr (std::is_same_v<std::decay_t<decltype(target)>, modules::Choice>) {
          return target.get();
        } else {
          return *target;
        }
      },
      key.value);
}

}  // namespace grtx::sim
