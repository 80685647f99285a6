// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/design_comparison.h"

#include <algorithm>
#include <optional>

#include "grtx/base/error.h"
#include "grtx/base/nearest_name.h"

namespace grtx::experiment {

DesignComparison::DesignComparison(const std::vector<std::string>& names, bool several_objects,
                                   const std::function<void(const ComparedDesign&)>& check) {
  for (const std::string& name : names) {
    if (std::find(explore::design_names().begin(), explore::design_names().end(), name) !=
        explore::design_names().end())
      continue;
    throw Error("--designs", name,
                "is no design, the nearest is '" + nearest_name(name, explore::design_names()) + "'");
  }
  std::optional<Error> refused;
  for (const explore::Design& design : explore::designs()) {
    const ComparedDesign compared(design);
    if (!names.empty() && std::find(names.begin(), names.end(), design.name) == names.end()) continue;
    if (several_objects && !traces::is_two_level(compared.kind)) continue;
    try {
      if (names.empty() && check) check(compared);
    } catch (const Error& error) {
      if (!refused) refused = error;
      left_out_[design.name] = error.what();
      continue;
    }
    designs_.push_back(compared);
    names_.push_back(design.name);
  }
  if (designs_.empty() && refused) throw *refused;
  if (designs_.empty()) throw Error("--designs", names.front(), "cannot trace several objects: they need two levels");
  std::stable_sort(designs_.begin(), designs_.end(),
                   [](const ComparedDesign& a, const ComparedDesign& b) { return a.kind < b.kind; });
}

}  // namespace grtx::experiment
