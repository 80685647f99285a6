// SPDX-License-Identifier: Apache-2.0
// The memory behind the GPU's sockets: watchdog, conservation laws, statistics, waveforms and timelines use nothing but
// this interface. The built-in DRAM implements it; other implementations can be registered.
#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "grtx/base/state_bytes.h"
#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/tlm/memory_traffic.h"

namespace grtx::sim {

class Gpu;
struct BuildOptions;

using modules::MemoryTraffic;

/// Record of a run's memory.
struct MemoryCounters {
  std::string model;
  MemoryTraffic traffic;              ///< of all channels, after draining
  double busy_cycles = 0.0;           ///< MemorySystem::busy_core_cycles() when the last warp had ended
  modules::StatisticList statistics;  ///< gpu.dram.*, after draining
};

/// A value for waveforms, read after each core cycle.
struct MemoryProbe {
  std::string name;  ///< below gpu.dram
  unsigned width = 32;
  std::function<std::uint64_t()> value;
};

/// Built with its modules before the simulation starts, and bound to gpu.dram by its factory. Its kernel events may go
/// on forever (refresh): the simulator steps the kernel by spans of time and asks idle(). A model with a ClockDomain of
/// its own may let it run ahead of the kernel together with the GPU's (RunAhead); without that, all clocks follow the
/// kernel.
class MemorySystem {
 public:
  virtual ~MemorySystem() = default;

  /// Its value of the configuration key dram.model.
  virtual std::string model() const = 0;
  /// Channels with separate counts and signals; usually one per socket.
  virtual unsigned channels() const = 0;
  /// Since the start or the last restart().
  virtual MemoryTraffic traffic(unsigned channel) const = 0;
  /// Requests begun and not answered.
  virtual std::uint64_t outstanding(unsigned channel) const = 0;
  /// True if nothing is under way, response phases included.
  virtual bool idle() const = 0;
  /// Writes all queues, for the report of a deadlock.
  virtual void dump_state(std::ostream& out) const = 0;

  /// Grows with every sign of life, for the watchdog.
  virtual std::uint64_t progress() const { return total().responses; }
  /// Latest time for which anything is scheduled inside, as known now: until then the watchdog takes a lack of progress
  /// for waiting. A model whose events never end (refresh) leaves it at 0.
  virtual std::uint64_t awaited_fs() const { return 0; }
  /// Adds statistics named prefix + ".name". At least .reads, .writes, .bytes and .responses, which energy and reports
  /// need: describe_traffic() adds these.
  virtual void statistics(modules::StatisticList& list, const std::string& prefix) const {
    describe_traffic(list, prefix);
  }
  /// Least core cycles that the busiest channel's data bus needed for what it has moved: a lower bound on the run.
  virtual double busy_core_cycles() const { return 0.0; }
  /// Signals besides the outstanding requests of each channel.
  virtual std::vector<MemoryProbe> probes() const { return {}; }
  /// Errors found by the end of a run, one line each; any makes the run count as broken.
  virtual std::vector<std::string> violations() const { return {}; }
  /// The part of it that is on the die, for area and energy.
  virtual std::optional<modules::Inventory> inventory() const { return std::nullopt; }

  /// Called when idle, before another launch (Gpu::restart()). Sets counts to 0 and returns true; false: not supported.
  /// cold: closes open rows, if it can.
  virtual bool restart(modules::Caches) { return false; }
  /// Writes what restart(Caches::warm) keeps, for a run in another process; called when idle. False: not supported.
  virtual bool save(StateWriter&) const { return false; }
  /// Reads what save() wrote; called before the first launch. False: not supported.
  virtual bool load(StateReader&) { return false; }

  MemoryTraffic total() const;

 protected:
  void describe_traffic(modules::StatisticList& list, const std::string& prefix) const;
};

/// Builds a memory system and binds it to every socket of gpu.dram. gpu.config() and gpu.map() give its parameters;
/// both arguments outlive what it returns.
using MemorySystemFactory = std::function<std::unique_ptr<MemorySystem>(Gpu& gpu, const BuildOptions& build)>;

inline constexpr const char* kBuiltInMemory = "built_in";

/// Makes `name` a value of dram.model; call before configurations are read. Throws std::logic_error if it already is
/// one. needs_file: it reads dram.simulator.config, which then becomes a key.
void register_memory_system(const std::string& name, MemorySystemFactory factory, bool needs_file = false);
/// kBuiltInMemory, then the registered ones in order.
std::vector<std::string> memory_system_names();
/// The names that were registered with needs_file.
std::vector<std::string> memory_systems_with_file();
/// The factory of a name. Throws Error, which lists the known names, if it is not registered.
const MemorySystemFactory& memory_system(const std::string& name);
/// Builds the memory of `gpu`: by `own` if it is not empty, else by the factory of gpu.config().dram_model. Throws
/// Error if that makes nothing.
std::unique_ptr<MemorySystem> make_memory(const MemorySystemFactory& own, Gpu& gpu, const BuildOptions& build);

}  // namespace grtx::sim
