// SPDX-License-Identifier: Apache-2.0
// A unit that hands a NAME to its base: to compile with sc_core::sc_module_name, not with char (a const char*).
#include <type_traits>

#include "grtx/modules/kernel/clocked_module.h"

using Name = std::conditional_t<std::is_same_v<NAME, char>, const char*, const sc_core::sc_module_name&>;

class Unit final : public grtx::modules::ClockedModule {
 public:
  Unit(Name name, grtx::modules::ClockDomain& clock) : ClockedModule(name, clock) {}

 private:
  grtx::Cycle tick(grtx::Cycle) override { return grtx::modules::kNever; }
};
