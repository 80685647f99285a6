// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/kernel/link.h"

#include "grtx/modules/kernel/unit_fault.h"

namespace grtx::modules {

void LinkObject::refuse(const char* rule) const { unit_fault(name(), rule); }

}  // namespace grtx::modules
