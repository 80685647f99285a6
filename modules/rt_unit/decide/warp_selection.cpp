#include "grtx/modules/rt_unit/decide/warp_selection.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "grtx/base/declare/named_enum.h"
#include "grtx/base/error.h"
#include "grtx/modules/rt_unit/decide/policies/greedy_then_oldest.h"
#include "grtx/modules/rt_unit/decide/policies/oldest_first.h"
#include "grtx/modules/rt_unit/decide/policies/round_robin.h"

namespace grtx::modules {
namespace {

using Registered = std::vector<std::pair<std::string, WarpSelectionFactory>>;

// The one list of names; what a program registers is there for its whole life.
Registered& registered() {
  static Registered all = {{"oldest_first", [] { return std::make_unique<OldestFirst>(); }},
                           {"round_robin", [] { return std::make_unique<RoundRobin>(); }},
                           {"greedy_then_oldest", [] { return std::make_unique<GreedyThenOldest>(); }}};
  return all;
}

const WarpSelectionFactory* find(std::string_view name) {
  const auto found =
      std::find_if(registered().begin(), registered().end(), [&](const auto& policy) { return policy.first == name; });
  return found == registered().end() ? nullptr : &found->second;
}

}  // namespace

void register_warp_selection(const std::string& name, WarpSelectionFactory factory) {
  if (find(name) != nullptr) throw std::logic_error("the warp selection " + name + " exists already");
  registered().emplace_back(name, std::move(factory));
}

std::vector<std::string> warp_selection_names() {
  std::vector<std::string> names;
  for (const auto& policy : registered()) names.push_back(policy.first);
  return names;
}

std::unique_ptr<WarpSelection> make_warp_selection(std::string_view name) {
  if (const WarpSelectionFactory* factory = find(name)) return (*factory)();
  throw Error("configuration", "rt.scheduler.policy", unknown_name(name, warp_selection_names()));
}

}  // namespace grtx::modules
