// SPDX-License-Identifier: Apache-2.0
// Fixed parts of a trace file, and limits by which a reader rejects corrupt sizes. See docs/model/trace-format.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace grtx::traces {

// As in PNG, a byte above 0x7F and both kinds of line end reveal damage by text-mode transfers.
inline constexpr std::array<std::uint8_t, 8> kFileMagic{0x93, 'G', 'R', 'T', 'X', '\r', '\n', 0x1A};
inline constexpr std::array<std::uint8_t, 8> kTrailerMagic{'G', 'R', 'T', 'X', 'E', 'N', 'D', '\n'};

inline constexpr std::size_t kPreambleBytes = 8 + 4 + 4 + 8;  ///< magic, version, header length, header hash
inline constexpr std::size_t kChunkPreambleBytes = 4 + 8;     ///< payload length, payload hash
inline constexpr std::size_t kTrailerBytes = 8 + 8;           ///< footer offset, magic

inline constexpr std::uint64_t kMaxHeaderBytes = 1ULL << 20;
inline constexpr std::uint64_t kMaxTotalsBytes = 1ULL << 16;
/// Most bytes of a group's columns before compression; 32 rays of ten million visits each stay below it.
inline constexpr std::uint64_t kMaxGroupBytes = 1ULL << 30;

}  // namespace grtx::traces
