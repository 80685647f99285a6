#include "grtx/rtl_tlm/estimate/model/model_simulation.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/base/stopwatch.h"
#include "grtx/rtl_tlm/estimate/model/anchors.h"
#include "grtx/rtl_tlm/gpu/mode_keys.h"
#include "grtx/rtl_tlm/run/host_speed.h"
#include "grtx/rtl_tlm/run/simulation_inputs.h"
#include "grtx/rtl_tlm/run/statistics_json.h"

namespace grtx::sim {
namespace {

constexpr std::uint64_t kL1Rung = 32 << 10, kL2Rung = 1 << 20;

/// A place between anchors: what counts how much.
template <typename T>
struct Weighted {
  T value{};
  double weight = 1.0;
};

/// Caches that have anchors: `rung` times powers of four. The two around `bytes`, or the one.
std::vector<Weighted<std::uint64_t>> rungs_around(std::uint64_t bytes, std::uint64_t rung) {
  std::uint64_t below = rung;
  while (below > bytes) below /= 4;
  while (below * 4 <= bytes) below *= 4;
  if (below == bytes) return {{bytes, 1.0}};
  const double share = std::log2(static_cast<double>(bytes) / static_cast<double>(below)) / 2.0;
  return {{below, 1.0 - share}, {below * 4, share}};
}

/// Rungs that the geometry allows; where it does not allow one, the size itself has anchors.
template <typename Set>
std::vector<Weighted<std::uint64_t>> allowed_rungs(const GpuConfig& config, std::uint64_t bytes, std::uint64_t rung,
                                                   const Set& set) {
  auto rungs = rungs_around(bytes, rung);
  for (const auto& size : rungs) {
    GpuConfig other = config;
    set(other, size.value);
    try {
      check_config(other, "");
    } catch (const Error&) {
      return {{bytes, 1.0}};
    }
  }
  return rungs;
}

/// Runs of the same trace at the same time wait for each other while something is made that is kept beside it.
class TraceLock {
 public:
  explicit TraceLock(const std::string& trace_path) : file_(::open(trace_path.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (file_ >= 0) ::flock(file_, LOCK_EX);
  }
  ~TraceLock() {
    if (file_ >= 0) ::close(file_);
  }
  TraceLock(const TraceLock&) = delete;
  TraceLock& operator=(const TraceLock&) = delete;

 private:
  int file_;
};

/// The machines whose anchors surround a configuration.
std::vector<Weighted<GpuConfig>> corners_of(const GpuConfig& config) {
  const auto set_l1 = [](GpuConfig& c, std::uint64_t bytes) { c.l1.geometry.bytes = bytes; };
  const auto set_l2 = [](GpuConfig& c, std::uint64_t bytes) { c.l2_bytes = bytes; };
  const GpuConfig defaults;
  std::vector<Weighted<GpuConfig>> corners;
  for (const auto& l1 : allowed_rungs(config, config.l1.geometry.bytes, kL1Rung, set_l1)) {
    for (const auto& l2 : allowed_rungs(config, config.l2_bytes, kL2Rung, set_l2)) {
      Weighted<GpuConfig> corner{config, l1.weight * l2.weight};
      set_l1(corner.value, l1.value);
      set_l2(corner.value, l2.value);
      corner.value.rt.warp_buffer.entries = defaults.rt.warp_buffer.entries;
      corner.value.rt.checkpoint.lanes = defaults.rt.checkpoint.lanes;
      corners.push_back(std::move(corner));
    }
  }
  return corners;
}

/// The anchors around a warp buffer, linear on the scale of logarithms.
std::vector<Weighted<const Anchor*>> anchors_around(const TiedModel& model, unsigned entries) {
  const std::vector<Anchor>& anchors = model.anchors;
  const auto after =
      std::find_if(anchors.begin(), anchors.end(), [&](const Anchor& a) { return a.entries >= entries; });
  if (after == anchors.end()) return {{&anchors.back(), 1.0}};
  if (after == anchors.begin() || after->entries == entries) return {{&*after, 1.0}};
  const auto before = after - 1;
  const double share = std::log2(static_cast<double>(entries) / before->entries) /
                       std::log2(static_cast<double>(after->entries) / before->entries);
  return {{&*before, 1.0 - share}, {&*after, share}};
}

class Estimation {
 public:
  Estimation(const std::string& trace_path, const GpuConfig& config, const SimulationOptions& options)
      : reader_(trace_path), config_(config), options_(options) {
    if (!reader_.header().frame_groups.empty()) {
      throw Error(reader_.path(), "", "a sequence of frames needs cycle or fast mode: the model has no warm caches");
    }
    if (const Unmodelled lack = unmodelled(config, SimulationMode::model)) {
      throw Error("configuration", std::string(lack.key), lack.rule);
    }
  }

  SimulationResult run() {
    std::vector<Weighted<TiedModel>> corners;
    const TraceCounts counts = prepare(corners);
    double log_cycles = 0.0;
    std::map<std::string, double> blended;
    for (const Weighted<TiedModel>& corner : corners) {
      const TiedModel& model = corner.value;
      anchors_ += model.anchors.size();
      const auto modelled = [&](const GpuConfig& c) {
        return std::log(modelled_cycles(counts, reader_.header(), c, model.latency, model.bandwidth));
      };
      double value = modelled(config_);
      for (const auto& [anchor, weight] : anchors_around(model, config_.rt.warp_buffer.entries)) {
        GpuConfig at = model.machine;
        at.rt.warp_buffer.entries = anchor->entries;
        const double residual = std::log(anchor->cycles) - modelled(at);
        value += weight * residual;
        largest_residual_ = std::max(largest_residual_, std::fabs(residual));
        for (const auto& [name, number] : anchor->statistics) blended[name] += corner.weight * weight * number;
      }
      log_cycles += corner.weight * value;
    }
    return finished(static_cast<Cycle>(std::llround(std::exp(log_cycles))), blended);
  }

 private:
  TraceCounts prepare(std::vector<Weighted<TiedModel>>& corners) const {
    const TraceLock lock(reader_.path());
    TraceCounts counts = counts_of(reader_);
    for (const Weighted<GpuConfig>& corner : corners_of(config_)) {
      corners.push_back({tied_model(reader_, counts, corner.value, options_.price), corner.weight});
    }
    return counts;
  }

  SimulationResult finished(Cycle cycles, const std::map<std::string, double>& blended) const {
    SimulationResult r;
    r.cycles = cycles;
    modules::StatisticList& list = r.statistics;
    list.add("gpu.cycles", cycles, "cycles", "estimated by the model");
    list.add("gpu.time_us", static_cast<double>(cycles) / config_.core_mhz, "us", "gpu.cycles at the core clock");
    list.add("gpu.rt.node_visits", reader_.totals().visits(), "visits", "nodes processed by lanes");
    for (const StatisticOfModel& s : statistics_of_model()) {
      const auto found = blended.find(s.name);
      if (found == blended.end()) continue;
      list.add(s.name, found->second, s.unit, std::string(s.description) + ", between fast runs of other sizes");
    }
    list.add("gpu.model.anchors", anchors_, "runs", "fast runs that the estimate lies between");
    list.add(
        "gpu.model.residual", largest_residual_, "ratio",
        "largest logarithm of fast mode's cycles over the warp model's at one of them, which the estimate corrects");
    const double wall = seconds_since(start_);
    r.host.add("host.wall_seconds", wall, "s", "wall time of the estimate");
    add_host_speed(r.host, {cycles, reader_.totals().visits(), wall, wall}, config_);
    r.inputs = simulation_inputs(reader_, config_);
    r.inputs["mode"] = name_of(SimulationMode::model);
    r.document = statistics_document(config_json(config_), r.inputs, r.statistics, r.host);
    return r;
  }

  traces::Reader reader_;
  const GpuConfig& config_;
  const SimulationOptions& options_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::uint64_t anchors_ = 0;
  double largest_residual_ = 0.0;
};

}  // namespace

SimulationResult simulate_model(const std::string& trace_path, const GpuConfig& config,
                                const SimulationOptions& options) {
  check_config(config, "configuration");
  if (config.dram_model != kBuiltInMemory) {
    throw Error("model mode", "dram.model", "must be built_in: fast mode has no other");
  }
  return Estimation(trace_path, config, options).run();
}

}  // namespace grtx::sim
