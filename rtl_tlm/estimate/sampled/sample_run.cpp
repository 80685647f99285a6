#include "grtx/rtl_tlm/estimate/sampled/sample_run.h"

#include <algorithm>

namespace grtx::sim {
namespace {

class Ends final : public modules::WarpObserver {
 public:
  Ends(const std::vector<std::uint64_t>& groups, unsigned resident_warps)
      : groups_(groups), resident_warps_(resident_warps), cycles(groups.size()) {}
  void launched(unsigned sm, unsigned slot, const traces::RayGroup& group, Cycle /*now*/) override {
    const std::size_t place = std::size_t{sm} * resident_warps_ + slot;
    if (place >= running_.size()) running_.resize(place + 1);
    running_[place] =
        static_cast<std::size_t>(std::lower_bound(groups_.begin(), groups_.end(), group.index) - groups_.begin());
  }
  void ended(unsigned sm, unsigned slot, Cycle now) override {
    cycles[running_[std::size_t{sm} * resident_warps_ + slot]] = now;
  }

 private:
  const std::vector<std::uint64_t>& groups_;
  unsigned resident_warps_;
  std::vector<std::size_t> running_;  ///< position of the group in each warp slot

 public:
  std::vector<Cycle> cycles;
};

}  // namespace

std::unique_ptr<ChildProcess> start_sample(const std::string& trace_path, const SampleRun& run, SimulationMode engine) {
  return std::make_unique<ChildProcess>("sample", [&trace_path, &run, engine] {
    Ends ends(run.groups, run.machine.config.resident_warps);
    SimulationOptions options;
    options.groups = run.groups;
    options.observer = &ends;
    const SimulationResult result = simulate(trace_path, run.machine.config, options, engine);
    nlohmann::ordered_json json;
    json["cycles"] = result.cycles;
    json["ends"] = ends.cycles;
    json["stats"] = result.document.at("stats");
    json["violations"] = result.violations;
    return json.dump();
  });
}

void finish_sample(ChildProcess& child, SampleRun& run) {
  const nlohmann::ordered_json json = nlohmann::ordered_json::parse(child.result());
  run.cycles = json.at("cycles").get<double>();
  run.group_end = json.at("ends").get<std::vector<double>>();
  run.stats = json.at("stats");
  run.violations = json.at("violations").get<std::vector<std::string>>();
}

}  // namespace grtx::sim
