// The designs that a run compares: all four of the paper, or sw and grtx alone for a scene of several objects.
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
/// The named designs of the paper's comparison, ordered so that designs with the same acceleration structure are
/// neighbours.
inline constexpr std::array<Design, 4> kDesigns = {{{"baseline", frontend::AccelKind::tri20, false},
                                                    {"hw", frontend::AccelKind::tri20, true},
                                                    {"sw", frontend::AccelKind::tlas_tri20, false},
                                                    {"grtx", frontend::AccelKind::tlas_tri20, true}}};

/// The designs that can trace a scene. Several objects need a two-level structure, so only sw and grtx can trace them.
class DesignComparison {
 public:
  explicit DesignComparison(bool several_objects);
  const std::vector<Design>& designs() const { return designs_; }   ///< in the order of tracing
  const std::vector<std::string>& names() const { return names_; }  ///< in the order of the table
  /// The design that speed-ups are relative to.
  const std::string& reference() const { return names_.front(); }
  std::span<const std::string> others() const { return std::span(names_).subspan(1); }

 private:
  std::vector<Design> designs_;
  std::vector<std::string> names_;
};

}  // namespace grtx::sim
