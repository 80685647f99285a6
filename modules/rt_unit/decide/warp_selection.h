// Which warp of the warp buffer the RT scheduler serves: a policy, free of SystemC, chosen by its name. Policies of the
// project stand in policies/, one file each; one of your own is registered before the first RT unit is made.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "grtx/base/strong.h"

namespace grtx::modules {

class WarpSelection {
 public:
  virtual ~WarpSelection() = default;
  /// candidates: one bit an entry, not 0. ages: acceptance number of the warp in each entry. Returns the chosen entry.
  virtual unsigned select(LaneMask candidates, const std::vector<std::uint64_t>& ages) = 0;
};

using WarpSelectionFactory = std::function<std::unique_ptr<WarpSelection>()>;

/// Makes `name` a value of rt.scheduler.policy. Throws std::logic_error when it is one already.
void register_warp_selection(const std::string& name, WarpSelectionFactory factory);
/// The values of rt.scheduler.policy, those of the project first.
std::vector<std::string> warp_selection_names();
/// Throws Error that lists the names for an unknown one.
std::unique_ptr<WarpSelection> make_warp_selection(std::string_view name);

}  // namespace grtx::modules
