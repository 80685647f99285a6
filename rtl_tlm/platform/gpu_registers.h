// SPDX-License-Identifier: Apache-2.0
// The registers of the GPU as a component: where they lie, what their bits say, and how bytes of them are read and
// written. docs/guide/platform.md has them for a driver's author.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "grtx/rtl_tlm/platform/picture.h"

namespace grtx::sim {

/// Byte offsets of the registers, 32 bits each; accesses are of any bytes of them. Written bytes of a register leave
/// its others as they read.
enum class GpuRegister : std::uint64_t {
  control = 0x00,       ///< written: ControlBits; reads as 0
  status = 0x04,        ///< StatusBits
  trace = 0x08,         ///< number of the trace that the next launch runs; taken when control is written
  cycles = 0x10,        ///< of the last launch, 64 bits
  cycles_high = 0x14,   ///< the upper 32 of them
  error = 0x18,         ///< LaunchError of the last start
  launches = 0x1c,      ///< launches that have ended without an error
  traces = 0x20,        ///< number of traces
  fault = 0x24,         ///< address on the bus that LaunchError::bus is about, 64 bits
  fault_high = 0x28,    ///< the upper 32 of them
  picture = 0x2c,       ///< bus address of the next launch's picture, 64 bits; these four are taken with `trace`
  picture_high = 0x30,  ///< the upper 32 of them
  pitch = 0x34,         ///< bytes from one row of the picture to the next; 0: those of a row
  format = 0x38,        ///< PictureFormat; 0: no picture is written
};
inline constexpr std::uint64_t kGpuRegisterBytes = 0x3c;

struct ControlBits {
  static constexpr std::uint32_t kStart = 1;  ///< begins a launch, from cold caches unless kKeepCaches
  /// With kStart: caches and open rows stay as the last launch left them.
  static constexpr std::uint32_t kKeepCaches = 2;
  static constexpr std::uint32_t kAcknowledge = 4;  ///< lowers the interrupt
  static constexpr std::uint32_t kReset = 8;        ///< abandons the launch under way; with kStart: and begins another
};
struct StatusBits {
  static constexpr std::uint32_t kBusy = 1, kDone = 2, kError = 4;
};
enum class LaunchError : std::uint32_t {
  none = 0,
  no_such_trace = 1,
  busy = 2,          ///< started during a launch, which goes on
  stands_still = 3,  ///< deadlock: no progress although work remains; stays busy until kReset
  memory = 4,        ///< the memory system cannot restart, or has requests that it does not answer
  broken_law = 5,    ///< the launch has ended, but SimulationResult::violations is not empty
  other_scene = 6,   ///< kKeepCaches, but the caches hold another scene
  bus = 7,           ///< the memory has refused a request, whose address is in `fault`: the launch was abandoned
  aborted = 8,       ///< abandoned by kReset, or by the port, while it ran
  picture = 9,       ///< the picture cannot be as the registers say, or the memory does not take it
};

/// What the registers that cannot be written tell of the component.
struct GpuState {
  bool busy = false;
  bool done = false;
  LaunchError error = LaunchError::none;
  std::uint64_t cycles = 0;  ///< of the last launch
  std::uint32_t launches = 0;
  std::uint32_t traces = 0;
  std::uint64_t fault = 0;
};

/// The registers that hold their last write. Plain C++.
class GpuRegisters {
 public:
  /// Bytes from `first` on, which must be those of registers.
  void read(std::uint64_t first, std::span<unsigned char> bytes, const GpuState& now) const;
  /// Control is written last, since it starts a launch as the others say: command(value). Writes to registers that only
  /// tell are ignored.
  void write(std::uint64_t first, std::span<const unsigned char> bytes, const GpuState& now,
             const std::function<void(std::uint32_t)>& command);
  void reset() { *this = {}; }

  std::uint32_t trace() const { return trace_; }
  const Picture& picture() const { return picture_; }

 private:
  std::uint32_t word(GpuRegister which, const GpuState& now) const;
  void set(GpuRegister which, std::uint32_t value);

  std::uint32_t trace_ = 0;
  Picture picture_;
};

}  // namespace grtx::sim
