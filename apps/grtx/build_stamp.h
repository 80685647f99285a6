// SPDX-License-Identifier: Apache-2.0
// Which sources and which compiler a program is made of. cmake/build_stamp.cmake writes the values with each build.
#pragma once

namespace grtx::apps {

/// Short hash of the commit, with "-dirty" behind it where tracked files differ from it. "unknown" where neither git
/// nor an archive that git made can say.
extern const char* const kCommit;
/// "GNU 12.2.0", "Clang 14.0.6".
extern const char* const kCompiler;

}  // namespace grtx::apps
