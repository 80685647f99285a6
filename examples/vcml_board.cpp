// SPDX-License-Identifier: Apache-2.0
// A board of VCML (https://github.com/machineware-gmbh/vcml): its bus and memory, our GPU, and a bus master that
// launches it, sleeps until the interrupt, and reads the picture from the memory. docs/guide/platform.md.
//   vcml_board -c board.trace_file=room.grtx -c board.contents=room.grtxmem -c board.picture=room.ppm
#include <vcml.h>

#include <cstdint>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/rtl_tlm/gpu/monitored_memory.h"
#include "grtx/rtl_tlm/platform/gpu_component.h"
#include "grtx/traces/reader.h"

namespace {

using namespace grtx::sim;

constexpr vcml::u64 kRegisters = 0x1000'0000, kMemory = 0x8000'0000, kMemoryBytes = 0x1000'0000;
constexpr vcml::u64 kPicture = 0x8f00'0000;  ///< behind what the GPU's map takes

/// The GPU's memory is the bus: each of its sockets is a master.
class BusMemory final : public MonitoredMemory {
 public:
  BusMemory(Gpu& gpu, vcml::generic::bus& bus) : MonitoredMemory(gpu, "vcml", true) {
    for (unsigned i = 0; i < channels(); ++i) bus.bind(socket(i));
  }
};

/// What a driver does.
class Driver final : public vcml::component {
 public:
  Driver(const sc_core::sc_module_name& name, const std::string& trace, const std::string& picture)
      : component(name), trace_(trace), picture_(picture) {
    SC_HAS_PROCESS(Driver);
    SC_THREAD(program);
  }
  vcml::tlm_initiator_socket bus{"bus"};
  vcml::gpio_target_socket interrupt{"interrupt"};
  std::uint32_t error = ~0u;

 private:
  void write(GpuRegister to, std::uint64_t word) {
    check(bus.writew(kRegisters + static_cast<vcml::u64>(to), static_cast<std::uint32_t>(word)));
  }
  std::uint32_t read(GpuRegister from) {
    std::uint32_t word = 0;
    check(bus.readw(kRegisters + static_cast<vcml::u64>(from), word));
    return word;
  }
  static void check(tlm::tlm_response_status status) {
    if (status != tlm::TLM_OK_RESPONSE) throw grtx::Error("vcml_board", "driver", "the bus refuses an access");
  }
  void program() {
    write(GpuRegister::trace, 0);
    write(GpuRegister::picture, kPicture & 0xffff'ffff);
    write(GpuRegister::picture_high, kPicture >> 32);
    write(GpuRegister::format, static_cast<std::uint32_t>(PictureFormat::rgba8));
    write(GpuRegister::control, ControlBits::kStart);
    sync();  // a driver that sleeps has no time ahead
    if (!interrupt.read()) wait(interrupt.posedge_event());
    error = read(GpuRegister::error);
    std::printf("%u cycles, error %u\n", read(GpuRegister::cycles), error);
    write(GpuRegister::control, ControlBits::kAcknowledge);
    read_picture();
    vcml::request_stop();
  }
  void read_picture() {
    const grtx::traces::Reader reader(trace_);
    const std::uint32_t width = reader.header().width, height = reader.header().height;
    std::ofstream file(picture_, std::ios::binary);
    file << "P6\n" << width << ' ' << height << "\n255\n";
    std::vector<char> row(4 * std::size_t{width});
    for (std::uint32_t y = 0; y < height; ++y) {
      check(bus.read(kPicture + y * row.size(), row.data(), static_cast<unsigned>(row.size())));
      for (std::size_t x = 0; x < width; ++x) file.write(&row[4 * x], 3);
    }
    if (!file) throw grtx::Error(picture_, "", "cannot be written");
  }
  std::string trace_, picture_;
};

class Board final : public vcml::system {
 public:
  explicit Board(const sc_core::sc_module_name& called) : system(called) {
    bus.bind(driver.bus);
    bus.bind(memory.in, kMemory, kMemory + kMemoryBytes - 1);
    bus.bind(gpu.registers, kRegisters, kRegisters + kGpuRegisterBytes - 1);
    gpu.interrupt.bind(line);
    driver.interrupt.bind(line);
    reset.rst.bind(reset_line);
    gpu.reset.bind(reset_line);
    for (vcml::component* part : {static_cast<vcml::component*>(&bus), static_cast<vcml::component*>(&memory),
                                  static_cast<vcml::component*>(&driver)}) {
      clock.clk.bind(part->clk);
      reset.rst.bind(part->rst);
    }
  }
  vcml::property<std::string> trace_file{"trace_file", "room.grtx"}, contents{"contents", "room.grtxmem"},
      picture{"picture", "room.ppm"};
  vcml::generic::clock clock{"clock", 100 * mwr::MHz};
  vcml::generic::reset reset{"reset"};
  vcml::generic::bus bus{"bus"};
  vcml::generic::memory memory{"memory", kMemoryBytes};
  Driver driver{"driver", trace_file, picture};
  sc_core::sc_signal<bool> line{"line"}, reset_line{"reset_line"};
  GpuComponent gpu{"gpu", options()};

 private:
  GpuComponent::Options options() {
    GpuComponent::Options options;
    options.machine = load_config("", {"gpu.sms=4"});
    options.traces = {trace_file.get()};
    options.contents = {contents.get()};
    options.base = kMemory;
    options.memory = [this](Gpu& of, const BuildOptions&) { return std::make_unique<BusMemory>(of, bus); };
    return options;
  }
};

}  // namespace

int sc_main(int, char**) {
  try {
    grtx::modules::set_time_resolution_to_fs();
    Board board("board");
    const int code = board.run();
    return code != 0 ? code : board.driver.error == 0 ? 0 : 1;
  } catch (const grtx::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
