// SPDX-License-Identifier: Apache-2.0
// The register file of an SM. Like the number of warp slots, it limits the resident warps of an SM.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "grtx/base/error.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/lane_loop.h"

namespace grtx::modules {

inline constexpr unsigned kMostResidentWarps = 64;  ///< warp slots of an SM: bits of a WarpMask
/// Throws Error for a number of warp slots that no SM can have.
inline void check_resident_warps(unsigned slots) {
  if (slots == 0 || slots > kMostResidentWarps) {
    throw Error("configuration", "resident_warps", "must be 1 to " + std::to_string(kMostResidentWarps));
  }
}

struct RegisterFile {
  std::uint64_t registers = 65536;
  unsigned registers_per_thread = 0;
  unsigned payload_registers = 0;

  /// Number of warps whose registers fit the register file; the largest integer if registers do not limit it.
  std::uint64_t warps() const {
    if (registers_per_thread == 0) return ~std::uint64_t{0};
    return registers / (std::uint64_t{registers_per_thread + payload_registers} * kMaxLanes);
  }
  /// Number of resident warps of an SM with `slots` warp slots.
  unsigned resident_warps(unsigned slots) const {
    return static_cast<unsigned>(std::min<std::uint64_t>(slots, warps()));
  }
  void parameters(ParameterList& list) {
    list.add("registers", registers, {1, 1e9}, "registers", "32-bit registers of an SM, for the hardware cost",
             kVulkanSim);
    list.add("registers_per_thread", registers_per_thread, {0, 255}, "registers",
             "of the program without its payload; with simt.registers they limit the warps of an SM; 0: they do not",
             kOurs);
    list.add("payload_registers", payload_registers, {0, 255}, "registers",
             "of a thread beside these: a k-buffer handed to the shaders as payload, two per entry", kOurs);
    list.rule(
        "payload_registers", [this] { return payload_registers == 0 || registers_per_thread != 0; },
        "needs simt.registers_per_thread");
    list.rule(
        "registers_per_thread", [this] { return warps() >= 1; }, "must leave simt.registers for a warp");
  }
};

}  // namespace grtx::modules
