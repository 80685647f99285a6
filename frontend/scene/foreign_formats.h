// SPDX-License-Identifier: Apache-2.0
// Formats of Gaussians that people have and this project does not read: what to say of such a file. One table.
#pragma once

#include <string>
#include <string_view>

namespace grtx::frontend {

/// What the bytes of such a format are, and how they become a scene that is read; "" if they are of none that is known.
std::string foreign_content(std::string_view bytes);
/// The same by the file's name, for bytes that tell nothing.
std::string foreign_name(const std::string& path);

}  // namespace grtx::frontend
