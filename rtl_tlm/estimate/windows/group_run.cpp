// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/estimate/windows/group_run.h"

#include <algorithm>

#include "grtx/base/json.h"
#include "grtx/rtl_tlm/run/statistics_json.h"
#include "grtx/rtl_tlm/run/trace_source.h"

namespace grtx::sim {
namespace {

/// Of an L1, what is given to it for groups that were left out: more would take the place of what warps under way use
/// again and again (stacks, buffers), which in a whole run stays.
constexpr std::uint64_t kPartOfL1 = 4;

/// Notes launches and ends. When groups were left out before a launch, the L2 is given what these would have read, and
/// the L1s, in turn, the last of it.
class Launches final : public modules::WarpObserver {
 public:
  Launches(const std::string& trace_path, const GpuConfig& config, const std::vector<std::uint64_t>& groups)
      : ends(groups.size()),
        reader_(trace_path),
        counter_(reader_.header(), config.rt.memory.traffic),
        groups_(groups),
        resident_warps_(config.resident()) {}
  void attach(Gpu& gpu) { gpu_ = &gpu; }
  void launched(unsigned sm, unsigned slot, const traces::RayGroup& group, Cycle now) override {
    if (work.size() < groups_[launches.size()]) skip_to(groups_[launches.size()]);
    work.push_back(counter_.count(group, gpu_->map(), {}));
    const std::size_t index = std::size_t{sm} * resident_warps_ + slot;
    if (index >= running_.size()) running_.resize(index + 1);
    running_[index] = launches.size();
    launches.push_back(now);
  }
  void ended(unsigned sm, unsigned slot, Cycle now) override {
    ends[running_[std::size_t{sm} * resident_warps_ + slot]] = now;
  }

  std::vector<Cycle> launches, ends;  ///< by position
  std::vector<GroupWork> work;        ///< by group of the trace

 private:
  void skip_to(std::uint64_t next) {
    const GpuConfig& config = gpu_->config();
    std::vector<std::vector<std::uint64_t>> read(gpu_->sms().size());
    while (work.size() < next) {
      reader_.read(work.size(), skipped_);
      check_group(skipped_, reader_.header(), reader_.path());
      std::vector<std::uint64_t>& by_sm = read[work.size() % read.size()];
      work.push_back(counter_.count(skipped_, gpu_->map(), [&](std::uint64_t sector) {
        gpu_->slices()[config.interleave.slice(sector)]->preload(sector);
        by_sm.push_back(sector);
      }));
    }
    const std::uint64_t most = config.l1.geometry.bytes / modules::kSectorBytes / kPartOfL1;
    for (std::size_t sm = 0; sm < read.size(); ++sm) {
      const std::size_t left_out = read[sm].size() - std::min<std::size_t>(most, read[sm].size());
      for (std::size_t i = left_out; i < read[sm].size(); ++i) gpu_->sms()[sm]->l1().preload(read[sm][i]);
    }
  }

  traces::Reader reader_;
  WorkCounter counter_;
  traces::RayGroup skipped_;
  const std::vector<std::uint64_t>& groups_;
  Gpu* gpu_ = nullptr;
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
    s.kind = modules::StatisticKind::state;  // numbers within a run: nobody combines them
    list.add(std::move(s));
  }
  return list;
}

}  // namespace

std::unique_ptr<ChildProcess> start_group_run(const std::string& trace_path, const GpuConfig& config,
                                              const GroupRun& run) {
  return std::make_unique<ChildProcess>("sample", [&] {
    Launches launches(trace_path, config, run.groups);
    SimulationOptions options;
    options.groups = run.groups;
    options.observer = &launches;
    options.built = [&launches](Gpu& gpu) { launches.attach(gpu); };
    options.read_at = run.read_at;
    const SimulationResult result = simulate(trace_path, config, options);
    nlohmann::ordered_json json;
    json["cycles"] = result.cycles;
    json["launched"] = launches.launches;
    json["ended"] = launches.ends;
    json["work"] = nlohmann::ordered_json::array();
    for (const GroupWork& w : launches.work) json["work"].push_back({w.sectors, w.distinct, w.steps, w.calls});
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
  run.work.clear();
  for (const auto& w : json.at("work")) run.work.push_back({w.at(0), w.at(1), w.at(2), w.at(3)});
  run.statistics = list_from_json(json.at("statistics"));
  run.at_launches.clear();
  for (const auto& so_far : json.at("at_launches")) run.at_launches.push_back(numbers_from_json(so_far));
  run.bounds.clear();
  for (const auto& b : json.at("bounds")) run.bounds.push_back({b.at(0), b.at(1), b.at(2), b.at(3)});
  run.violations = json.at("violations").get<std::vector<std::string>>();
}

}  // namespace grtx::sim
