// SPDX-License-Identifier: Apache-2.0
// Messages for files of Gaussians in formats that this project does not read. One table.
#pragma once

#include <string>
#include <string_view>

namespace grtx::frontend {

/// Names the format of these bytes and says how to convert them to one that is read; "" for an unknown format.
std::string foreign_content(std::string_view bytes);
/// The same by the file's name, for bytes that do not show their format.
std::string foreign_name(const std::string& path);

}  // namespace grtx::frontend
