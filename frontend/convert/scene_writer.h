// SPDX-License-Identifier: Apache-2.0
// Writes scenes as INRIA .ply, .spz and .usda, for programs that read no other format.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/frontend/scene/scene_rows.h"

namespace grtx::frontend {

/// Little-endian binary .ply with the rows' own values: converting a .ply keeps every number. Throws Error for SH
/// degree 4.
void write_ply(const RawRows& rows, const std::string& path);

/// .spz version 3 in the format's own axes (right, up, back). Positions have 24 bits, with as many fraction bits as the
/// largest one allows, at most 12 (steps of 1/4096); scales have steps of 1/16 in the logarithm, opacities and colours
/// 1/255, SH 1/128. Rows with a non-finite number cannot be written; returns how many were left out. Throws Error for
/// SH degree 4 and for positions beyond 2^23.
std::uint64_t write_spz(const RawRows& rows, const std::string& path);

/// USD text with one ParticleField3DGaussianSplat, in the axes of a .ply, without a transform. Each number reads as the
/// float that it was, opacities up to a logit of 20. Rows with a non-finite number cannot be written; returns how many
/// were left out. Throws Error for SH degree 4.
std::uint64_t write_usda(const RawRows& rows, const std::string& path);

}  // namespace grtx::frontend
