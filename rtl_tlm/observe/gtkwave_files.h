// SPDX-License-Identifier: Apache-2.0
// Files with which GTKWave shows a waveform like the block diagram: a save file with nested groups, formats and
// colours, and one filter file per enumeration, which turns values into coloured words.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "grtx/rtl_tlm/observe/vcd_writer.h"

namespace grtx::sim {

/// Times of the dump in fs, for the first view.
struct WaveformSpan {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  std::uint64_t period = 1;  ///< of the core clock
};

/// Path of an enumeration's filter beside a save file: F.gtkw and warp_state give F.warp_state.filter.
std::string filter_file_of(const std::string& save_path, const Enumeration& enumeration);

/// Writes save_path and the filters of all enumerations of `signals`. The save file names dump and filters by absolute
/// path, as GTKWave looks for filters in its own working folder.
void write_gtkwave_files(const std::string& vcd_path, const std::string& save_path,
                         const std::vector<SignalInfo>& signals, const WaveformSpan& span);

}  // namespace grtx::sim
