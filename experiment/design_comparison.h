// SPDX-License-Identifier: Apache-2.0
// The designs that a run compares: those asked for, else all but those that refuse an option of the user; of these the
// ones with two levels for a scene of several objects.
#pragma once

#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "grtx/explore/sweep/designs.h"
#include "grtx/frontend/accel/accel_options.h"

namespace grtx::experiment {

/// A named design, with its structure as the tracer knows it.
struct ComparedDesign : explore::Design {
  explicit ComparedDesign(const explore::Design& design)
      : explore::Design(design), kind(frontend::accel_from_name(design.accel)) {}
  frontend::AccelKind kind;
};

class DesignComparison {
 public:
  /// names: of designs; empty: all that can be compared. several_objects: only two-level structures can trace the
  /// scene. check: throws Error if a design refuses what the user set; asked only without names. Throws Error for an
  /// unknown name, and, that of the first design, if none is left.
  DesignComparison(const std::vector<std::string>& names, bool several_objects,
                   const std::function<void(const ComparedDesign&)>& check = {});
  /// In the order of tracing: designs with the same structure follow each other.
  const std::vector<ComparedDesign>& designs() const { return designs_; }
  const std::vector<std::string>& names() const { return names_; }  ///< in the order of the table
  /// The design that speed-ups are relative to: the first of the table.
  const std::string& reference() const { return names_.front(); }
  const std::map<std::string, std::string>& left_out() const { return left_out_; }  ///< of all designs: name -> why
  std::span<const std::string> others() const { return std::span(names_).subspan(1); }

 private:
  std::vector<ComparedDesign> designs_;
  std::vector<std::string> names_;
  std::map<std::string, std::string> left_out_;
};

}  // namespace grtx::experiment
