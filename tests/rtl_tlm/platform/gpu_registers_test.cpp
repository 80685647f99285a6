// SPDX-License-Identifier: Apache-2.0
// Bytes of the registers, as a driver reads and writes them.
#include "grtx/rtl_tlm/platform/gpu_registers.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <vector>

namespace grtx::sim {
namespace {

class GpuRegistersTest : public ::testing::Test {
 protected:
  std::uint32_t read(GpuRegister which) const {
    std::array<unsigned char, 4> bytes{};
    registers.read(static_cast<std::uint64_t>(which), bytes, now);
    std::uint32_t word = 0;
    std::memcpy(&word, bytes.data(), 4);
    return word;
  }
  void write(std::uint64_t first, const std::vector<unsigned char>& bytes) {
    registers.write(first, bytes, now, [this](std::uint32_t value) {
      commands.push_back(value);
      trace_at_command = registers.trace();
    });
  }
  void write(GpuRegister which, const std::vector<unsigned char>& bytes) {
    write(static_cast<std::uint64_t>(which), bytes);
  }

  GpuRegisters registers;
  GpuState now;
  std::vector<std::uint32_t> commands;
  std::uint32_t trace_at_command = 0;
};

TEST_F(GpuRegistersTest, TellTheStateOfTheComponent) {
  now = {true, true, LaunchError::bus, 0x5'0000'0007, 3, 2, 0x9'0000'0008};
  const struct {
    GpuRegister which;
    std::uint32_t value;
  } cases[] = {
      {GpuRegister::control, 0},    {GpuRegister::status, StatusBits::kBusy | StatusBits::kDone | StatusBits::kError},
      {GpuRegister::cycles, 7},     {GpuRegister::cycles_high, 5},
      {GpuRegister::error, 7},      {GpuRegister::launches, 3},
      {GpuRegister::traces, 2},     {GpuRegister::fault, 8},
      {GpuRegister::fault_high, 9},
  };
  for (const auto& c : cases) EXPECT_EQ(read(c.which), c.value) << static_cast<std::uint64_t>(c.which);
}

TEST_F(GpuRegistersTest, KeepWhatIsWritten) {
  write(GpuRegister::trace, {4, 0, 0, 0});
  write(GpuRegister::picture, {1, 0, 0, 0, 2, 0, 0, 0, 64, 0, 0, 0, 1, 0, 0, 0});
  EXPECT_EQ(registers.trace(), 4u);
  EXPECT_EQ(registers.picture().address, 0x2'0000'0001u);
  EXPECT_EQ(registers.picture().pitch, 64u);
  EXPECT_EQ(read(GpuRegister::format), 1u);
  registers.reset();
  EXPECT_EQ(read(GpuRegister::trace), 0u);
  EXPECT_EQ(read(GpuRegister::pitch), 0u);
}

TEST_F(GpuRegistersTest, AWrittenByteLeavesTheOthersOfItsRegister) {
  write(GpuRegister::pitch, {0x11, 0x22, 0x33, 0x44});
  write(static_cast<std::uint64_t>(GpuRegister::pitch) + 2, {0x99});
  EXPECT_EQ(read(GpuRegister::pitch), 0x44992211u);
}

TEST_F(GpuRegistersTest, ControlIsWrittenLastOfATransferOfSeveral) {
  write(GpuRegister::control, {ControlBits::kStart, 0, 0, 0, 0xFF, 0xFF, 0xFF, 0xFF, 6, 0, 0, 0});
  EXPECT_EQ(commands, std::vector<std::uint32_t>{ControlBits::kStart});
  EXPECT_EQ(trace_at_command, 6u) << "the launch takes the trace of the same transfer";
}

TEST_F(GpuRegistersTest, IgnoreWritesToThoseThatOnlyTell) {
  for (const GpuRegister which : {GpuRegister::status, GpuRegister::cycles, GpuRegister::error, GpuRegister::launches,
                                  GpuRegister::traces, GpuRegister::fault}) {
    write(which, {0xFF, 0xFF, 0xFF, 0xFF});
    EXPECT_EQ(read(which), 0u) << static_cast<std::uint64_t>(which);
  }
  EXPECT_TRUE(commands.empty());
}

}  // namespace
}  // namespace grtx::sim
