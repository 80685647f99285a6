#include "grtx/study/design_comparison.h"

#include <algorithm>
#include <string_view>

namespace grtx::sim {
namespace {

constexpr std::array<const char*, 4> kTableOrder = {"baseline", "sw", "hw", "grtx"};

}  // namespace

DesignComparison::DesignComparison(bool several_objects) {
  for (const Design& design : kDesigns) {
    if (!several_objects || traces::is_two_level(design.accel)) designs_.push_back(design);
  }
  for (const char* name : kTableOrder) {
    const auto has_name = [&](const Design& design) { return name == std::string_view(design.name); };
    if (std::any_of(designs_.begin(), designs_.end(), has_name)) names_.emplace_back(name);
  }
}

}  // namespace grtx::sim
