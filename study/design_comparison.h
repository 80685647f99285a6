// The designs that a run compares: all four of the paper, or those that a scene has.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "grtx/frontend/accel/acceleration_structure.h"

namespace grtx::sim {

struct Design {
  const char* name;
  frontend::AccelKind accel;
  bool checkpoint;
};
/// The named designs of the paper's comparison, ordered so that two share one acceleration structure.
inline constexpr std::array<Design, 4> kDesigns = {{{"baseline", frontend::AccelKind::tri20, false},
                                                    {"hw", frontend::AccelKind::tri20, true},
                                                    {"sw", frontend::AccelKind::tlas_tri20, false},
                                                    {"grtx", frontend::AccelKind::tlas_tri20, true}}};

/// The designs that a scene has: several objects need a two-level structure, so theirs are sw and grtx.
class DesignComparison {
 public:
  explicit DesignComparison(bool several_objects);
  const std::vector<Design>& designs() const { return designs_; }   ///< in the order of tracing
  const std::vector<std::string>& names() const { return names_; }  ///< in the order of the table
  /// Over which speed-ups are.
  const std::string& reference() const { return names_.front(); }
  std::span<const std::string> others() const { return std::span(names_).subspan(1); }

 private:
  std::vector<Design> designs_;
  std::vector<std::string> names_;
};

}  // namespace grtx::sim
