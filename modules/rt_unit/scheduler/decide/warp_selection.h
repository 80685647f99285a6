// SPDX-License-Identifier: Apache-2.0
// Warp selection policies of the RT scheduler: which warp of the warp buffer is served. Selected by name, free of
// SystemC. The project's are in policies/, one file each. Register one of your own before the first RT unit is built.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "grtx/base/strong.h"

namespace grtx::modules {

/// What lanes do next.
enum class NextStep : std::uint8_t {
  internal,  ///< visit an internal node
  instance,  ///< visit an instance leaf
  leaf,      ///< visit a leaf of primitives
  other,     ///< drop a node beyond t_max, or take an entry of the checkpoint buffer: nothing is fetched
};

/// What a policy may ask of a candidate.
struct SelectableWarp {
  unsigned unfinished = 0;          ///< lanes that have not finished
  std::array<unsigned, 4> lanes{};  ///< [NextStep] of these, lanes that are served if the warp is chosen
  unsigned stack_depth = 0;         ///< entries of the deepest stack of these lanes, or of the warp's common stack
  unsigned active() const { return lanes[0] + lanes[1] + lanes[2] + lanes[3]; }
  unsigned next(NextStep step) const { return lanes[static_cast<std::size_t>(step)]; }
};

/// The warps of the warp buffer; what is not asked costs nothing.
class SelectableWarps {
 public:
  /// entry: that of a candidate.
  virtual SelectableWarp at(unsigned entry) const = 0;

 protected:
  ~SelectableWarps() = default;
};

class WarpSelection {
 public:
  virtual ~WarpSelection() = default;
  /// candidates: one bit per entry, not 0. ages: [entry] acceptance number, lower is older. Returns the chosen entry;
  /// one that is no candidate ends the run.
  virtual unsigned select(LaneMask candidates, const std::vector<std::uint64_t>& ages,
                          const SelectableWarps& warps) = 0;
};

using WarpSelectionFactory = std::function<std::unique_ptr<WarpSelection>()>;

/// Makes `name` a value of rt.scheduler.policy. Throws std::logic_error if the name is taken.
void register_warp_selection(const std::string& name, WarpSelectionFactory factory);
/// The registered values of rt.scheduler.policy, the project's first.
std::vector<std::string> warp_selection_names();
/// Throws Error for an unknown name, with the known ones, and for a factory that makes nothing.
std::unique_ptr<WarpSelection> make_warp_selection(std::string_view name);
/// The entry that `selection` chooses. Throws WrongAnswer naming the policy if it is no candidate. name: the policy's.
unsigned selected_entry(WarpSelection& selection, const std::string& name, LaneMask candidates,
                        const std::vector<std::uint64_t>& ages, const SelectableWarps& warps);

}  // namespace grtx::modules
