// What stands behind the GPU's memory sockets, as the rest of the simulator sees it: the watchdog, the conservation
// laws, statistics, waveforms and timelines ask nothing but this. The built-in DRAM is one, others come from outside.
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

/// What a run keeps of its memory.
struct MemoryCounters {
  std::string model;
  MemoryTraffic traffic;              ///< of all channels, drained
  double busy_cycles = 0.0;           ///< MemorySystem::busy_core_cycles() when the last warp had ended
  modules::StatisticList statistics;  ///< gpu.dram.*, drained
};

/// A value for waveforms, read after each core cycle.
struct MemoryProbe {
  std::string name;  ///< below gpu.dram
  unsigned width = 32;
  std::function<std::uint64_t()> value;
};

/// Built with its modules before the simulation starts, and bound to gpu.dram by its factory. A model whose kernel
/// events never end (refresh) is welcome: the simulator steps the kernel by spans of time and asks idle(). A model with
/// a ClockDomain of its own may let it run ahead of the kernel together with the GPU's (RunAhead); without that, all
/// clocks follow the kernel.
class MemorySystem {
 public:
  virtual ~MemorySystem() = default;

  /// As in the configuration key dram.model.
  virtual std::string model() const = 0;
  /// Channels that are counted and shown apart; mostly one a socket.
  virtual unsigned channels() const = 0;
  /// Since the start.
  virtual MemoryTraffic traffic(unsigned channel) const = 0;
  /// Requests inside: begun, and not answered.
  virtual std::uint64_t outstanding(unsigned channel) const = 0;
  /// Nothing is under way, response phases included.
  virtual bool idle() const = 0;
  /// All queues, for a run that stands still.
  virtual void dump_state(std::ostream& out) const = 0;

  /// Grows with every sign of life, for the watchdog.
  virtual std::uint64_t progress() const { return total().responses; }
  /// The last time for which anything is scheduled inside, as far as it is known now, for the watchdog: until then
  /// standing still is waiting. A model that never runs out of events (refresh) leaves it at 0.
  virtual std::uint64_t awaited_fs() const { return 0; }
  /// Adds prefix + ".name". At least .reads, .writes, .bytes and .responses, which energy and reports are made from:
  /// describe_traffic() adds these.
  virtual void statistics(modules::StatisticList& list, const std::string& prefix) const {
    describe_traffic(list, prefix);
  }
  /// Core cycles that the busiest channel's data bus needed at least for what it has moved: a lower bound on the run.
  virtual double busy_core_cycles() const { return 0.0; }
  /// Signals besides the outstanding requests of each channel.
  virtual std::vector<MemoryProbe> probes() const { return {}; }
  /// What it found wrong by the end of a run, a line each: the run then counts as broken.
  virtual std::vector<std::string> violations() const { return {}; }
  /// The part of it that is on the die, for area and energy.
  virtual std::optional<modules::Inventory> inventory() const { return std::nullopt; }

  /// Another launch follows (Gpu::restart()); nothing is under way. Counts from 0 again and returns true, or cannot.
  /// cold: open rows are closed, where it can do that.
  virtual bool restart(modules::Caches) { return false; }
  /// What restart(Caches::warm) keeps, for a run in another process; nothing is under way. False: it cannot.
  virtual bool save(StateWriter&) const { return false; }
  /// Before the first launch.
  virtual bool load(StateReader&) { return false; }

  MemoryTraffic total() const;

 protected:
  void describe_traffic(modules::StatisticList& list, const std::string& prefix) const;
};

/// Builds a memory system and binds it to every socket of gpu.dram. gpu.config() and gpu.map() say what is needed; both
/// arguments outlive what it returns.
using MemorySystemFactory = std::function<std::unique_ptr<MemorySystem>(Gpu& gpu, const BuildOptions& build)>;

inline constexpr const char* kBuiltInMemory = "built_in";

/// Makes `name` a value of dram.model, to be called before configurations are read. Throws std::logic_error when it is
/// one already.
/// needs_file: it reads dram.simulator.config, which is then offered as a key.
void register_memory_system(const std::string& name, MemorySystemFactory factory, bool needs_file = false);
/// kBuiltInMemory, then those registered, in order.
std::vector<std::string> memory_system_names();
/// Those that were registered with needs_file.
std::vector<std::string> memory_systems_with_file();
/// Throws Error, which lists the names, for one that is not registered.
const MemorySystemFactory& memory_system(const std::string& name);

}  // namespace grtx::sim
