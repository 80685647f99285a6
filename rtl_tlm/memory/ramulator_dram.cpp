// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/memory/ramulator_dram.h"

#include <ramulator/base/config.h>
#include <ramulator/base/factory.h>
#include <ramulator/base/request.h>
#include <ramulator/frontend/i_frontend.h>
#include <ramulator/memory_system/i_memory_system.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <fstream>
#include <ostream>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"

namespace grtx::sim {

using modules::kNever;

namespace {

/// One memory system of Ramulator with its front end.
struct System {
  explicit System(const std::string& file) {
    check_regular_file(file);
    // Ramulator ends the program for a file that it cannot open.
    if (!std::ifstream(file)) throw Error{file, "dram.simulator.config", "cannot be opened"};
    try {
      const Ramulator::ConfigNode config = Ramulator::Config::parse_config_file(file);
      frontend.reset(Ramulator::Factory::create_frontend(config));
      memory.reset(Ramulator::Factory::create_memory_system(config));
      frontend->connect_memory_system(memory.get());
      memory->connect_frontend(frontend.get());
    } catch (const std::exception& e) {
      throw Error{file, "dram.simulator.config", e.what()};
    }
    if (memory->get_tCK() <= 0 || memory->get_tx_bytes() <= 0) {
      throw Error{file, "dram.simulator.config", "names a memory system without a clock or a burst"};
    }
  }

  std::unique_ptr<Ramulator::IFrontEnd> frontend;
  std::unique_ptr<Ramulator::IMemorySystem> memory;
};

std::vector<System> build_systems(const PortedDramConfig& config) {
  config.interleave.check();
  std::vector<System> systems;
  for (unsigned i = 0; i < memories(config); ++i) systems.emplace_back(config.file);
  return systems;
}

// Ramulator's clock period is in whole picoseconds, but get_tCK() returns it in nanoseconds as a float.
double clock_mhz(const System& system) { return 1e6 / std::round(system.memory->get_tCK() * 1000.0F); }

}  // namespace

class RamulatorDram::Device final : public modules::ClockedModule {
 public:
  Device(const sc_core::sc_module_name& name, const PortedDramConfig& config, std::vector<System> systems,
         modules::ClockDomain& clock)
      : ClockedModule(name, clock),
        config_(config),
        systems_(std::move(systems)),
        burst_bytes_(static_cast<unsigned>(systems_.front().memory->get_tx_bytes())),
        sending_(config.interleave.slices) {
    const std::uint64_t period = clock_.period_fs();
    const DramPort::Config port{config.interleave.bytes, config.bytes, (config.fixed_latency_fs + period - 1) / period};
    for (unsigned i = 0; i < config.interleave.slices; ++i) {
      ports_.push_back(std::make_unique<DramPort>(("socket_" + std::to_string(i)).c_str(), port, clock_, alarm_));
    }
  }

  Cycle tick(Cycle now) override {
    catch_up(now);
    bool busy = false;
    for (unsigned i = 0; i < ports_.size(); ++i) busy |= !offer(i, now);
    Cycle due = kNever;
    for (const auto& port : ports_) due = std::min(due, port->step(now));
    return busy || accesses_ > 0 ? now + 1 : due;
  }

  bool idle() const {
    return std::all_of(ports_.begin(), ports_.end(), [](const auto& port) { return port->idle(); });
  }
  void print_own_statistics(std::ostream& out) {
    for (System& system : systems_) {
      system.memory->finalize();
      system.memory->print_stats(out);
    }
  }
  void dump_state(std::ostream& out) const {
    out << name() << ": clock " << ticked_ << ", accesses under way " << accesses_ << '\n';
    for (const auto& port : ports_) port->dump_state(out);
  }
  const std::vector<std::unique_ptr<DramPort>>& ports() const { return ports_; }
  unsigned burst_bytes() const { return burst_bytes_; }

 private:
  /// The waiting request of a port, sent in pieces of one access each.
  struct Sending {
    std::shared_ptr<unsigned> left;  ///< accesses without an answer, and one until the request is accepted
    unsigned sent = 0;               ///< bytes
  };

  // Clocks without requests only refresh, which depends on nothing outside: they are simulated when the next request
  // comes. Ramulator calls back from inside tick().
  void catch_up(Cycle now) {
    while (ticked_ < now) {
      ++ticked_;
      for (System& system : systems_) system.memory->tick();
    }
  }
  bool offer(unsigned slice, Cycle now);
  bool send(unsigned slice, std::uint64_t address, unsigned bytes, const ::tlm::tlm_generic_payload& payload);
  void end_access(unsigned slice, unsigned& left, ::tlm::tlm_generic_payload& payload);

  PortedDramConfig config_;
  std::vector<System> systems_;
  unsigned burst_bytes_;
  std::vector<std::unique_ptr<DramPort>> ports_;  ///< [slice]
  std::vector<Sending> sending_;                  ///< [slice]
  Cycle ticked_ = 0;                              ///< Ramulator's clock
  std::uint64_t accesses_ = 0;                    ///< accesses that Ramulator has taken and not answered
};

/// False while a request waits: Ramulator's queue is full, and the next clock tries again.
bool RamulatorDram::Device::offer(unsigned slice, Cycle now) {
  DramPort& port = *ports_[slice];
  const ::tlm::tlm_generic_payload* waiting = port.arrived(now);
  if (waiting == nullptr) return true;
  const unsigned bytes = waiting->get_data_length();
  Sending& sending = sending_[slice];
  if (sending.left == nullptr) {
    sending = {std::make_shared<unsigned>((bytes + burst_bytes_ - 1) / burst_bytes_ + 1), 0};
  }
  while (sending.sent < bytes) {
    const unsigned piece = std::min(burst_bytes_, bytes - sending.sent);
    if (!send(slice, waiting->get_address() + sending.sent, piece, *waiting)) return false;
    sending.sent += piece;
  }
  ::tlm::tlm_generic_payload& payload = port.accept(now);
  const std::shared_ptr<unsigned> left = std::move(sending.left);
  end_access(slice, *left, payload);  // the last answer may have come at once
  return true;
}

bool RamulatorDram::Device::send(unsigned slice, std::uint64_t address, unsigned bytes,
                                 const ::tlm::tlm_generic_payload& waiting) {
  using Ramulator::Request;
  System& system = systems_[memory_of(config_, slice)];
  const std::uint64_t local = address_in_memory(config_, slice, address);
  // Not const in truth: the request belongs to the port until accept(), and the port to this device.
  auto& payload = const_cast<::tlm::tlm_generic_payload&>(waiting);
  ++accesses_;
  const bool taken = system.frontend->receive_external_requests(
      waiting.is_write() ? Request::Type::Write : Request::Type::Read, static_cast<Ramulator::Addr_t>(local), 0,
      [this, slice, &payload, left = sending_[slice].left](Request&) {
        --accesses_;
        end_access(slice, *left, payload);
      },
      static_cast<int>(bytes));
  if (!taken) --accesses_;
  return taken;
}

void RamulatorDram::Device::end_access(unsigned slice, unsigned& left, ::tlm::tlm_generic_payload& payload) {
  if (--left == 0) ports_[slice]->complete(payload, ticked_, true);
}

RamulatorDram::RamulatorDram(const sc_core::sc_module_name& name, const PortedDramConfig& config) : sc_module(name) {
  std::vector<System> systems = build_systems(config);
  clock_ = std::make_unique<modules::ClockDomain>("clock", clock_mhz(systems.front()));
  device_ = std::make_unique<Device>("device", config, std::move(systems), *clock_);
}

RamulatorDram::~RamulatorDram() = default;

unsigned RamulatorDram::ports() const { return static_cast<unsigned>(device_->ports().size()); }
DramPort& RamulatorDram::port(unsigned slice) { return *device_->ports()[slice]; }
const DramPort& RamulatorDram::port(unsigned slice) const { return *device_->ports()[slice]; }
unsigned RamulatorDram::burst_bytes() const { return device_->burst_bytes(); }
bool RamulatorDram::idle() const { return device_->idle(); }
void RamulatorDram::print_own_statistics(std::ostream& out) { device_->print_own_statistics(out); }
void RamulatorDram::dump_state(std::ostream& out) const { device_->dump_state(out); }

}  // namespace grtx::sim
