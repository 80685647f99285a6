// SPDX-License-Identifier: Apache-2.0
// kMachinesFolder, the folder of the project's machines, for programs that link with its libraries.
#pragma once

#include "grtx/rtl_tlm/config/config_file.h"
