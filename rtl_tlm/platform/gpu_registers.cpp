// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/platform/gpu_registers.h"

#include <algorithm>
#include <cstring>

namespace grtx::sim {
namespace {

constexpr std::uint64_t kLow = 0xFFFFFFFF;

std::uint32_t low(std::uint64_t value) { return static_cast<std::uint32_t>(value); }
std::uint32_t high(std::uint64_t value) { return static_cast<std::uint32_t>(value >> 32); }

/// Calls each(register, offset in its word, place in the bytes, how many), from the last register to the first.
template <typename Each>
void by_register(std::uint64_t first, std::uint64_t bytes, Each&& each) {
  for (std::uint64_t end = first + bytes; end > first;) {
    const std::uint64_t offset = (end - 1) / 4 * 4, begin = std::max(first, offset);
    each(static_cast<GpuRegister>(offset), begin - offset, begin - first, end - begin);
    end = begin;
  }
}

}  // namespace

void GpuRegisters::read(std::uint64_t first, std::span<unsigned char> bytes, const GpuState& now) const {
  by_register(first, bytes.size(), [&](GpuRegister which, std::size_t in_word, std::size_t place, std::size_t count) {
    const std::uint32_t value = word(which, now);
    std::memcpy(&bytes[place], reinterpret_cast<const unsigned char*>(&value) + in_word, count);
  });
}

void GpuRegisters::write(std::uint64_t first, std::span<const unsigned char> bytes, const GpuState& now,
                         const std::function<void(std::uint32_t)>& command) {
  by_register(first, bytes.size(), [&](GpuRegister which, std::size_t in_word, std::size_t place, std::size_t count) {
    std::uint32_t value = word(which, now);
    std::memcpy(reinterpret_cast<unsigned char*>(&value) + in_word, &bytes[place], count);
    if (which == GpuRegister::control) return command(value);
    set(which, value);
  });
}

std::uint32_t GpuRegisters::word(GpuRegister which, const GpuState& now) const {
  switch (which) {
    case GpuRegister::status:
      return (now.busy ? StatusBits::kBusy : 0u) | (now.done ? StatusBits::kDone : 0u) |
             (now.error != LaunchError::none ? StatusBits::kError : 0u);
    case GpuRegister::trace:
      return trace_;
    case GpuRegister::cycles:
      return low(now.cycles);
    case GpuRegister::cycles_high:
      return high(now.cycles);
    case GpuRegister::error:
      return static_cast<std::uint32_t>(now.error);
    case GpuRegister::launches:
      return now.launches;
    case GpuRegister::traces:
      return now.traces;
    case GpuRegister::fault:
      return low(now.fault);
    case GpuRegister::fault_high:
      return high(now.fault);
    case GpuRegister::picture:
      return low(picture_.address);
    case GpuRegister::picture_high:
      return high(picture_.address);
    case GpuRegister::pitch:
      return picture_.pitch;
    case GpuRegister::format:
      return static_cast<std::uint32_t>(picture_.format);
    case GpuRegister::control:
      break;
  }
  return 0;
}

void GpuRegisters::set(GpuRegister which, std::uint32_t value) {
  switch (which) {
    case GpuRegister::trace:
      trace_ = value;
      return;
    case GpuRegister::picture:
      picture_.address = (picture_.address & ~kLow) | value;
      return;
    case GpuRegister::picture_high:
      picture_.address = (picture_.address & kLow) | std::uint64_t{value} << 32;
      return;
    case GpuRegister::pitch:
      picture_.pitch = value;
      return;
    case GpuRegister::format:
      picture_.format = static_cast<PictureFormat>(value);
      return;
    default:
      return;
  }
}

}  // namespace grtx::sim
