// .spz (Niantic): quantised attributes in blocks; versions 1 to 3 in one gzip stream, version 4 in zstd streams.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "grtx/frontend/scene/scene_rows.h"

namespace grtx::frontend {

/// Signs of the SH coefficients from k1 on when y and z change sign. The last one, of k24, is what the format's library
/// uses; the basis function itself is even in every axis.
inline constexpr std::array<float, 24> kSpzShSign{-1, -1, 1,                 //
                                                  -1, 1,  1,  -1, 1,         //
                                                  -1, 1,  -1, -1, 1, -1, 1,  //
                                                  -1, 1,  -1, 1,  1, -1, 1, -1, -1};

/// True when the bytes start like a gzip stream or like version 4.
bool is_spz(std::string_view bytes);

/// raw_axes: see SceneReadOptions::spz_raw_axes. Throws Error{file, place, rule}.
RawRows read_spz(std::string_view bytes, bool raw_axes, const std::string& file);

}  // namespace grtx::frontend
