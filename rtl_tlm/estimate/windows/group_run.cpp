// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/estimate/windows/group_run.h"

#include "grtx/base/json.h"

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

}  // namespace

std::unique_ptr<ChildProcess> start_group_run(const std::string& trace_path, const GpuConfig& config,
                                              const GroupRun& run) {
  return std::make_unique<ChildProcess>("sample", [&] {
    LaunchTimes times(run.groups.size(), config.resident());
    SimulationOptions options;
    options.groups = run.groups;
    options.observer = &times;
    const SimulationResult result = simulate(trace_path, config, options);
    nlohmann::ordered_json json;
    json["cycles"] = result.cycles;
    json["launched"] = times.launches;
    json["ended"] = times.ends;
    json["stats"] = result.document.at("stats");
    json["violations"] = result.violations;
    return json_text(json);
  });
}

void finish_group_run(ChildProcess& child, GroupRun& run) {
  const nlohmann::ordered_json json = parse_json(child.result(), "groups");
  run.cycles = json.at("cycles").get<double>();
  run.times.launched = json.at("launched").get<std::vector<double>>();
  run.times.ended = json.at("ended").get<std::vector<double>>();
  run.stats = json.at("stats");
  run.violations = json.at("violations").get<std::vector<std::string>>();
}

}  // namespace grtx::sim
