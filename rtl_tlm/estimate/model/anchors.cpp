#include "grtx/rtl_tlm/estimate/model/anchors.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "grtx/base/atomic_file.h"
#include "grtx/base/child_process.h"
#include "grtx/rtl_tlm/estimate/fast/fast_engine.h"
#include "grtx/rtl_tlm/estimate/model/model_work.h"
#include "grtx/rtl_tlm/estimate/sampled/scaled_machine.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;

constexpr const char* kSchema = "grtx.anchors/1";
constexpr std::array<unsigned, 3> kEntries = {1, 4, 16};
constexpr double kLargestFactor = 16.0;
constexpr int kHalvings = 14;  ///< of the logarithm of a factor: to 0.05 %
constexpr int kAlternations = 3;

std::string path_of(const traces::Reader& reader, const GpuConfig& machine) {
  return fmt::format("{}.anchors-{}.json", reader.path(), config_hash(machine));
}

/// The warp buffers that this machine can have.
std::vector<unsigned> warp_buffers(const GpuConfig& machine) {
  std::vector<unsigned> entries;
  for (const unsigned n : kEntries) {
    const unsigned possible = std::min(n, std::max(1U, machine.resident_warps / machine.rt_units));
    if (entries.empty() || entries.back() < possible) entries.push_back(possible);
  }
  return entries;
}

Anchor anchor_of(const ordered_json& json) {
  Anchor anchor{json.at("entries").get<unsigned>(), json.at("cycles").get<double>(), {}};
  for (const auto& [name, value] : json.at("statistics").items()) anchor.statistics[name] = value.get<double>();
  return anchor;
}

ordered_json json_of(const Anchor& anchor) {
  return {{"entries", anchor.entries}, {"cycles", anchor.cycles}, {"statistics", anchor.statistics}};
}

std::string run_anchor(const std::string& trace_path, const GpuConfig& config, const EnergyPricing& price) {
  SimulationOptions options;
  options.price = price;
  FastEngine engine;
  const SimulationResult result = simulate(trace_path, config, options, engine);
  Anchor anchor{config.rt.warp_buffer.entries, static_cast<double>(result.cycles), {}};
  const ordered_json& stats = result.document.at("stats");
  for (const StatisticOfModel& s : statistics_of_model()) {
    if (stats.contains(s.name)) anchor.statistics[s.name] = stats.at(s.name).at("value").get<double>();
  }
  return json_of(anchor).dump();
}

/// The factor at which `cycles_at` gives the wanted cycles; it rises or falls with the factor throughout.
template <typename CyclesAt>
double solve(const CyclesAt& cycles_at, double wanted, bool rising) {
  double low = -std::log(kLargestFactor), high = std::log(kLargestFactor);
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    const bool above = cycles_at(std::exp(middle)) > wanted;
    (above == rising ? high : low) = middle;
  }
  return std::exp(0.5 * (low + high));
}

void fit(TiedModel& model, const TraceCounts& counts, const traces::Header& header) {
  const auto cycles = [&](const Anchor& anchor, double latency, double bandwidth) {
    GpuConfig config = model.machine;
    config.rt.warp_buffer.entries = anchor.entries;
    return modelled_cycles(counts, header, config, latency, bandwidth);
  };
  const Anchor& least = model.anchors.front();
  const Anchor& most = model.anchors.back();
  for (int i = 0; i < kAlternations; ++i) {
    model.latency = solve([&](double f) { return cycles(least, f, model.bandwidth); }, least.cycles, true);
    if (model.anchors.size() < 2) return;
    model.bandwidth = solve([&](double f) { return cycles(most, model.latency, f); }, most.cycles, false);
  }
}

ordered_json read_json(const std::string& path) {
  return std::filesystem::exists(path) ? ordered_json::parse(read_file(path), nullptr, false) : ordered_json();
}

/// False: of something else, or damaged.
bool take(const ordered_json& json, const ordered_json& identity, TiedModel& model) {
  try {
    for (const auto& [name, value] : identity.items()) {
      if (json.at(name) != value) return false;
    }
    model.latency = json.at("latency").get<double>();
    model.bandwidth = json.at("bandwidth").get<double>();
    for (const ordered_json& anchor : json.at("anchors")) model.anchors.push_back(anchor_of(anchor));
    return !model.anchors.empty();
  } catch (const ordered_json::exception&) {
    model.anchors.clear();
    return false;
  }
}

}  // namespace

const std::vector<StatisticOfModel>& statistics_of_model() {
  static const std::vector<StatisticOfModel> list = {
      {"gpu.l1.node.hit_rate", "ratio", "node sectors that hit the L1"},
      {"gpu.l2.hit_rate", "ratio", "sectors that hit the L2"},
      {"gpu.l2.accesses", "sectors", "of the L2"},
      {"gpu.dram.bytes", "B", "moved by the DRAM"},
      {"gpu.rt.node_fetches", "fetches", "of the RT units"},
      {"gpu.rt.node_fetch_latency", "cycles", "from request to response, in the mean"},
      {"gpu.energy_nj", "nJ", "energy of the run"},
      {"gpu.energy_nj_per_ray", "nJ", "energy a ray"},
  };
  return list;
}

double modelled_cycles(const TraceCounts& counts, const traces::Header& header, const GpuConfig& config, double latency,
                       double bandwidth) {
  const std::vector<GroupWork> work = work_of(counts, header, config);
  std::vector<const GroupWork*> groups;
  groups.reserve(work.size());
  for (const GroupWork& group : work) groups.push_back(&group);
  ModelRates rates = nominal_rates(config);
  rates.step_cycles *= latency;
  rates.sm_sectors *= bandwidth;
  rates.sm_far *= bandwidth;
  rates.memory_sectors *= bandwidth;
  return std::max(1.0, run_model(groups, {}, model_of(config), rates).cycles);
}

TiedModel tied_model(const traces::Reader& reader, const TraceCounts& counts, const GpuConfig& machine,
                     const EnergyPricing& price) {
  TiedModel model;
  model.machine = machine;
  const ordered_json identity = {{"schema", kSchema},
                                 {"trace", reader.content_hash()},
                                 {"config", config_hash(machine)},
                                 {"program", std::string("grtx ") + GRTX_VERSION},
                                 {"energy", price != nullptr}};
  const std::string path = path_of(reader, machine);
  if (take(read_json(path), identity, model)) return model;
  for (const unsigned entries : warp_buffers(machine)) {
    GpuConfig config = machine;
    config.rt.warp_buffer.entries = entries;
    ChildProcess child("anchor", [&] { return run_anchor(reader.path(), config, price); });
    model.anchors.push_back(anchor_of(ordered_json::parse(child.result())));
  }
  fit(model, counts, reader.header());
  ordered_json json = identity;
  json["latency"] = model.latency;
  json["bandwidth"] = model.bandwidth;
  for (const Anchor& anchor : model.anchors) json["anchors"].push_back(json_of(anchor));
  const std::string folder = std::filesystem::path(path).parent_path().string();
  if (::access(folder.empty() ? "." : folder.c_str(), W_OK) == 0) write_file(path, json.dump(1) + "\n");
  return model;
}

}  // namespace grtx::sim
