// SPDX-License-Identifier: Apache-2.0
// Which rows a format of finite numbers can hold.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "grtx/frontend/scene/scene_rows.h"

namespace grtx::frontend {

/// Numbers of SH per row. Throws Error for SH degree 4, which readers of the formats that are written do not accept.
std::size_t harmonics_of(const RawRows& rows, const std::string& path);

/// Rows whose numbers are finite, in order. An opacity's logit may be infinite: it stands for 0 or 1.
std::vector<std::size_t> writable_rows(const RawRows& rows, std::size_t harmonics);

}  // namespace grtx::frontend
