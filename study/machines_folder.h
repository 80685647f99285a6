// Where the machines of the project are, for programs that link with its libraries: their target says it.
#pragma once

namespace grtx {

#ifdef GRTX_MACHINES_FOLDER  // comes with the target grtx::study
inline constexpr const char* kMachinesFolder = GRTX_MACHINES_FOLDER;
#endif

}  // namespace grtx
