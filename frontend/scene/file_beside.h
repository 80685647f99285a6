// SPDX-License-Identifier: Apache-2.0
// Reads a file that a scene file refers to. Paths outside the scene's folder are refused.
#pragma once

#include <string>

#include "grtx/base/files_read.h"

namespace grtx::frontend {

/// Contents of the file `name` in the folder of `file` or below. Names come from untrusted files: one that leads
/// elsewhere is refused. The file is noted in `files`. Throws Error{file, name, rule}.
std::string read_beside(const std::string& file, const std::string& name, FilesRead& files);

}  // namespace grtx::frontend
