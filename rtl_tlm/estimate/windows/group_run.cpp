// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/estimate/windows/group_run.h"

#include "grtx/base/json.h"
#include "grtx/rtl_tlm/run/statistics_json.h"

namespace grtx::sim {
namespace {

class LaunchTimes final : public modules::WarpObserver {
 public:
  LaunchTimes(std::size_t groups, unsigned resident_warps) : ends(groups), resident_warps_(resident_warps) {}
  void launched(unsigned sm, unsigned slot, const traces::RayGroup& /*group*/, Cycle now) override {
    const std::size_t index = std::size_t{sm} * resident_warps_ + slot;
    if (index >= running_.size()) running_.resize(index + 1);
    running_[index] = launches.size();
    launches.push_back(now);
  }
  void ended(unsigned sm, unsigned slot, Cycle now) override {
    ends[running_[std::size_t{sm} * resident_warps_ + slot]] = now;
  }

  std::vector<Cycle> launches, ends;  ///< by position

 private:
  unsigned resident_warps_;
  std::vector<std::size_t> running_;  ///< position of the group in each warp slot
};

/// Names and numbers only: there are many lists.
nlohmann::ordered_json numbers_json(const modules::StatisticList& list) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const modules::Statistic& s : list.items()) json.push_back({s.name, s.number(), s.of.part, s.of.whole});
  return json;
}

modules::StatisticList numbers_from_json(const nlohmann::ordered_json& json) {
  modules::StatisticList list;
  for (const nlohmann::ordered_json& j : json) {
    modules::Statistic s;
    s.name = j.at(0).get<std::string>();
    s.value = j.at(1).get<double>();
    s.of.part = j.at(2).get<std::uint64_t>();
    s.of.whole = j.at(3).get<std::uint64_t>();
    list.add(std::move(s));
  }
  return list;
}

}  // namespace

std::unique_ptr<ChildProcess> start_group_run(const std::string& trace_path, const GpuConfig& config,
                                              const GroupRun& run) {
  return std::make_unique<ChildProcess>("sample", [&] {
    LaunchTimes times(run.groups.size(), config.resident());
    SimulationOptions options;
    options.groups = run.groups;
    options.observer = &times;
    options.read_at = run.read_at;
    const SimulationResult result = simulate(trace_path, config, options);
    nlohmann::ordered_json json;
    json["cycles"] = result.cycles;
    json["launched"] = times.launches;
    json["ended"] = times.ends;
    json["statistics"] = list_json(result.statistics);
    json["at_launches"] = nlohmann::ordered_json::array();
    for (const modules::StatisticList& so_far : result.at_launches) json["at_launches"].push_back(numbers_json(so_far));
    json["bounds"] = nlohmann::ordered_json::array();
    for (const LowerBound& b : result.bounds) json["bounds"].push_back({b.name, b.cycles, b.description, b.of_chain});
    json["violations"] = result.violations;
    return json_text(json);
  });
}

void finish_group_run(ChildProcess& child, GroupRun& run) {
  const nlohmann::ordered_json json = parse_json(child.result(), "groups");
  run.cycles = json.at("cycles").get<double>();
  run.times.launched = json.at("launched").get<std::vector<double>>();
  run.times.ended = json.at("ended").get<std::vector<double>>();
  run.statistics = list_from_json(json.at("statistics"));
  run.at_launches.clear();
  for (const auto& so_far : json.at("at_launches")) run.at_launches.push_back(numbers_from_json(so_far));
  run.bounds.clear();
  for (const auto& b : json.at("bounds")) run.bounds.push_back({b.at(0), b.at(1), b.at(2), b.at(3)});
  run.violations = json.at("violations").get<std::vector<std::string>>();
}

}  // namespace grtx::sim
