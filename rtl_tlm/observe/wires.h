// SPDX-License-Identifier: Apache-2.0
// The signals of a waveform that the user selected. A probe adds all its wires; those outside the scope or above the
// level are not written.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "grtx/base/declare/named_enum.h"
#include "grtx/rtl_tlm/observe/observe_options.h"
#include "grtx/rtl_tlm/observe/vcd_writer.h"

namespace grtx::sim {

/// Bits that hold 0..largest.
inline unsigned width_for(std::uint64_t largest) {
  return static_cast<unsigned>(std::max(1, static_cast<int>(std::bit_width(largest))));
}

class Wire {
 public:
  Wire() = default;
  Wire(VcdWriter* writer, VcdWriter::Signal signal) : writer_(writer), signal_(signal) {}
  void set(std::uint64_t value) {
    if (value == last_) return;
    last_ = value;
    if (writer_ != nullptr) writer_->set(signal_, value);
  }

 private:
  VcdWriter* writer_ = nullptr;  ///< null: not selected
  VcdWriter::Signal signal_ = 0;
  std::uint64_t last_ = 0;
};

class Wires {
 public:
  /// scope: shell patterns separated by commas; a signal is selected when one of them matches its name or that of a
  /// scope around it, with or without the leading name of the GPU.
  Wires(VcdWriter& writer, const std::string& scope, WaveLevel level, const std::string& gpu = "gpu");

  Wire add(const std::string& name, unsigned width, WaveLevel level = WaveLevel::units,
           const Enumeration* enumeration = nullptr);
  /// Wires selected so far.
  std::size_t selected() const { return selected_; }

 private:
  VcdWriter& writer_;
  std::vector<std::string> patterns_;
  WaveLevel level_;
  std::string root_;  ///< first part of all names
  std::size_t selected_ = 0;
};

}  // namespace grtx::sim
