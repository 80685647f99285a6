#include "grtx/modules/dram/decide/dram_scheduling.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "grtx/base/declare/named_enum.h"
#include "grtx/base/error.h"
#include "grtx/modules/dram/decide/dram_config.h"
#include "grtx/modules/dram/decide/policies/fcfs.h"
#include "grtx/modules/dram/decide/policies/fr_fcfs.h"
#include "grtx/modules/dram/decide/policies/fr_fcfs_cap.h"

namespace grtx::modules {
namespace {

using Policies = std::vector<std::pair<std::string, DramSchedulingFactory>>;

// The one list of names; what a program registers is there for its whole life.
Policies& policies() {
  using Config = DramChannelConfig;
  static Policies all = {{kFrFcfs, [](const Config& c) { return std::make_unique<FrFcfs>(c.age_cap); }},
                         {"fcfs", [](const Config&) { return std::make_unique<Fcfs>(); }},
                         {"fr_fcfs_cap", [](const Config& c) { return std::make_unique<FrFcfsCap>(c); }}};
  return all;
}

const DramSchedulingFactory* find_policy(std::string_view name) {
  const auto found =
      std::find_if(policies().begin(), policies().end(), [&](const auto& policy) { return policy.first == name; });
  return found == policies().end() ? nullptr : &found->second;
}

}  // namespace

void register_dram_scheduling(const std::string& name, DramSchedulingFactory factory) {
  if (find_policy(name) != nullptr) throw std::logic_error("the DRAM scheduling " + name + " exists already");
  policies().emplace_back(name, std::move(factory));
}

std::vector<std::string> dram_scheduling_names() {
  std::vector<std::string> names;
  for (const auto& policy : policies()) names.push_back(policy.first);
  return names;
}

std::unique_ptr<DramScheduling> make_dram_scheduling(const DramChannelConfig& channel) {
  if (const DramSchedulingFactory* factory = find_policy(channel.scheduling)) return (*factory)(channel);
  throw Error("configuration", "dram.scheduling", unknown_name(channel.scheduling, dram_scheduling_names()));
}

}  // namespace grtx::modules
