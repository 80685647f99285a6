// SPDX-License-Identifier: Apache-2.0
// Source folder of the project's machines, for programs that link with its libraries; CMake defines it for their
// target.
#pragma once

namespace grtx {

#ifdef GRTX_MACHINES_FOLDER  // comes with the target grtx::study
inline constexpr const char* kMachinesFolder = GRTX_MACHINES_FOLDER;
#endif

}  // namespace grtx
