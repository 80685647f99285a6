// Files that a scene file names.
#pragma once

#include <string>

#include "grtx/base/files_read.h"

namespace grtx::frontend {

/// Bytes of the file `name` beside `file` or in folders below. Names come from inside a file of strangers: one that
/// leads elsewhere is refused. Noted in `files`. Throws Error{file, name, rule}.
std::string read_beside(const std::string& file, const std::string& name, FilesRead& files);

}  // namespace grtx::frontend
