// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/memory/dramsys_dram.h"

#include <DRAMSys/configuration/memspec/MemSpec.h>
#if __has_include(<DRAMSys/DRAMSys.h>)  // since 5.3
#include <DRAMSys/DRAMSys.h>
#include <DRAMSys/configuration/json/DRAMSysConfiguration.h>
#else
#include <DRAMSys/config/DRAMSysConfiguration.h>
#include <DRAMSys/simulation/DRAMSys.h>
#endif

#include <algorithm>
#include <exception>
#include <filesystem>
#include <iostream>
#include <ostream>
#include <sstream>
#include <variant>

#include "grtx/base/error.h"
#include "grtx/modules/tlm/at_initiator.h"
#include "grtx/modules/tlm/at_payload_pool.h"

namespace grtx::sim {

using modules::kNever;

namespace {

constexpr const char* kKey = "dram.simulator.config";

/// Other files that a configuration names lie in folders beside it up to 5.1, and since 5.2 where their names say,
/// relative to it. tCK is in picoseconds up to 5.1, in seconds since; no clock lasts a second, so that both can be
/// read.
template <typename File>
DRAMSys::Config::Configuration configuration_of(const File& file) {
  if constexpr (requires { DRAMSys::Config::from_path(file, file); }) {
    return DRAMSys::Config::from_path(file, std::filesystem::absolute(file).parent_path().string());
  } else {
    auto read = DRAMSys::Config::from_path(file);
    const auto to_seconds = [](auto& memory) {
      if (memory.memtimingspec.tCK >= 1.0) memory.memtimingspec.tCK *= 1e-12;
    };
    std::visit(to_seconds, read.memspec.getVariant());
    return read;
  }
}

DRAMSys::Config::Configuration read_configuration(const std::string& file) {
  try {
    return configuration_of(file);
  } catch (const std::exception& e) {
    throw Error{file, kKey, e.what()};
  }
}

/// DRAMSys prints a banner and its memory map to standard output, which belongs to our own results.
class QuietOutput {
 public:
  QuietOutput() : before_(std::cout.rdbuf(swallowed_.rdbuf())) {}
  ~QuietOutput() { std::cout.rdbuf(before_); }
  QuietOutput(const QuietOutput&) = delete;
  QuietOutput& operator=(const QuietOutput&) = delete;

 private:
  std::ostringstream swallowed_;
  std::streambuf* before_;
};

/// DRAMSys finishes its databases in end_of_simulation(), which the kernel does not call if modules are destroyed
/// before it ends. Destroying a DRAMSys with many unwritten records aborts the program, so the destructor calls it.
class EndedBeforeItGoes final : public DRAMSys::DRAMSys {
 public:
  using DRAMSys::DRAMSys;
  ~EndedBeforeItGoes() override {
    if (sc_core::sc_end_of_simulation_invoked()) return;
    const QuietOutput quiet;
    (this->*Access::end())();
  }

 private:
  /// DRAMSys's override is private, but what derives from sc_module may call it by the base class's name.
  struct Access : sc_core::sc_module {
    static auto end() -> void (sc_core::sc_module::*)() { return &Access::end_of_simulation; }
  };
};

}  // namespace

struct DramsysDram::Behind {
  explicit Behind(const PortedDramConfig& config) {
    config.interleave.check();
    const DRAMSys::Config::Configuration configuration = read_configuration(config.file);
    const unsigned instances = memories(config);
    const QuietOutput quiet;
    try {
      for (unsigned i = 0; i < instances; ++i) {
        systems.push_back(std::make_unique<EndedBeforeItGoes>(("dramsys_" + std::to_string(i)).c_str(), configuration));
      }
    } catch (const std::exception& e) {
      throw Error{config.file, kKey, e.what()};
    }
    const std::uint64_t needed = config.bytes / instances;
    if (spec().getSimMemSizeInBytes() < needed) {
      throw Error{config.file, kKey,
                  "the memory has " + std::to_string(spec().getSimMemSizeInBytes()) + " bytes, " +
                      std::to_string(needed) + " are needed"};
    }
  }
  const DRAMSys::MemSpec& spec() const { return systems.front()->getMemSpec(); }

  std::vector<std::unique_ptr<EndedBeforeItGoes>> systems;
};

class DramsysDram::Front final : public modules::ClockedModule {
 public:
  Front(const sc_core::sc_module_name& name, const PortedDramConfig& config, Behind& behind,
        modules::ClockDomain& clock)
      : ClockedModule(name, clock), config_(config) {
    const std::uint64_t period = clock_.period_fs();
    const DramPort::Config port{std::min(config.interleave.bytes, modules::AtPayload::kMaxBytes), config.bytes,
                                (config.fixed_latency_fs + period - 1) / period};
    for (unsigned i = 0; i < config.interleave.slices; ++i) {
      slices_.push_back(std::make_unique<Slice>(i, port, clock_, alarm_));
      slices_.back()->initiator.wake(&alarm_);
      slices_.back()->initiator.socket.bind(behind.systems[memory_of(config, i)]->tSocket);
    }
  }

  Cycle tick(Cycle now) override {
    Cycle due = kNever;
    for (unsigned i = 0; i < slices_.size(); ++i) due = std::min(due, serve(*slices_[i], now));
    return due;
  }

  bool idle() const {
    return std::all_of(slices_.begin(), slices_.end(),
                       [](const auto& slice) { return slice->port.idle() && slice->initiator.idle(); });
  }
  void dump_state(std::ostream& out) const {
    for (const auto& slice : slices_) {
      slice->port.dump_state(out);
      out << "  sent to DRAMSys and not answered: " << slice->initiator.outstanding() << '\n';
    }
  }
  unsigned ports() const { return static_cast<unsigned>(slices_.size()); }
  DramPort& port(unsigned slice) { return slices_[slice]->port; }

 private:
  struct Slice {
    Slice(unsigned i, const DramPort::Config& config, modules::ClockDomain& clock, modules::Alarm& alarm)
        : number(i),
          port(("socket_" + std::to_string(i)).c_str(), config, clock, alarm),
          initiator(("to_dramsys_" + std::to_string(i)).c_str(), clock) {}
    unsigned number;
    DramPort port;
    modules::AtInitiator initiator;
    std::vector<::tlm::tlm_generic_payload*> sent;  ///< [context of the initiator]
    std::vector<std::uint32_t> free;                ///< unused contexts
  };

  Cycle serve(Slice& slice, Cycle now);

  PortedDramConfig config_;
  std::vector<std::unique_ptr<Slice>> slices_;
};

Cycle DramsysDram::Front::serve(Slice& slice, Cycle now) {
  DramPort& port = slice.port;
  modules::AtInitiator& initiator = slice.initiator;
  initiator.update(now);
  while (const modules::AtInitiator::Completion* done = initiator.front(now)) {
    port.complete(*slice.sent[done->context], now, done->ok());
    slice.free.push_back(done->context);
    initiator.pop();
  }
  Cycle due = initiator.next_visible();
  if (port.arrived(now) != nullptr) {
    if (initiator.can_send(now)) {
      if (slice.free.empty()) {
        slice.free.push_back(static_cast<std::uint32_t>(slice.sent.size()));
        slice.sent.push_back(nullptr);
      }
      const std::uint32_t context = slice.free.back();
      slice.free.pop_back();
      ::tlm::tlm_generic_payload& payload = port.accept(now);
      slice.sent[context] = &payload;
      const std::uint64_t address = payload.get_address();
      initiator.send(address_in_memory(config_, slice.number, address), payload.get_data_length(), payload.is_write(),
                     context);
    } else {
      due = std::min(due, initiator.next_send());
    }
  }
  return std::min(due, port.step(now));
}

DramsysDram::DramsysDram(const sc_core::sc_module_name& name, const PortedDramConfig& config)
    : sc_module(name), behind_(std::make_unique<Behind>(config)) {
  const double period_fs = behind_->spec().tCK.to_seconds() * 1e15;
  clock_ = std::make_unique<modules::ClockDomain>("clock", 1e9 / period_fs);
  front_ = std::make_unique<Front>("front", config, *behind_, *clock_);
}

DramsysDram::~DramsysDram() = default;

unsigned DramsysDram::ports() const { return front_->ports(); }
DramPort& DramsysDram::port(unsigned slice) { return front_->port(slice); }
const DramPort& DramsysDram::port(unsigned slice) const { return front_->port(slice); }
unsigned DramsysDram::burst_bytes() const { return static_cast<unsigned>(behind_->spec().defaultBytesPerBurst); }
bool DramsysDram::idle() const { return front_->idle(); }
void DramsysDram::dump_state(std::ostream& out) const { front_->dump_state(out); }

}  // namespace grtx::sim
