// SPDX-License-Identifier: Apache-2.0
// Bandwidth and latency of a DRAM model alone, against the peak that its data buses allow, and the processor time of a
// request: the built-in one, or one of the DRAM simulators that the build was linked with. Readers without computation
// stand in for the L2 slices; `perfect` has no banks, and shows what they and the kernel take.
//
//   bench/dram_bandwidth                                        the built-in DRAM
//   bench/dram_bandwidth --config configs/dram/gddr6.toml       the same as a GDDR6 part
//   bench/dram_bandwidth --model dramsys --config gddr6.json --peak 112.28
//   bench/dram_bandwidth --model ramulator --config gddr6.yaml --peak 112.28 --bytes 64
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <systemc>
#include <vector>

#include "bench/processor_time.h"
#include "grtx/base/error.h"
#include "grtx/modules/dram/dram.h"
#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/tlm/at_initiator.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/memory/dram_simulators.h"

namespace {

using namespace grtx;
using modules::kNever;

struct Options {
  std::string model = "built_in";
  std::string config;
  bool shared = false;
  unsigned slices = 4;
  unsigned bytes = 32;
  unsigned in_flight = 64;
  std::uint64_t requests = 50'000;
  std::uint64_t footprint = std::uint64_t{256} << 20;
  double writes = 0.0;
  double request_mhz = 3500.0;
  double peak = 0.0;
  double fixed_latency_ns = 0.0;
};

enum class Pattern { streaming, random, dependent };

struct Pass {
  const char* name;
  Pattern pattern;
  unsigned in_flight;
  std::uint64_t requests;  ///< of each slice
};

/// One reader a slice, all in one module: keeps so many requests in flight until it has sent its share.
class Readers final : public modules::ClockedModule {
 public:
  Readers(const sc_core::sc_module_name& name, const Options& options, modules::ClockDomain& clock)
      : ClockedModule(name, clock), options_(options) {
    interleave_.slices = options.slices;
    for (unsigned i = 0; i < options.slices; ++i) {
      readers_.push_back(std::make_unique<Reader>(fmt::format("reader_{}", i), clock));
      readers_.back()->initiator.wake(&alarm_);
    }
  }

  modules::AtInitiator& initiator(unsigned slice) { return readers_[slice]->initiator; }

  void begin(const Pass& pass) {
    pass_ = pass;
    began_ = bench::cpu_seconds();
    first_ = clock_.edge_at_or_after_now() + 1;
    last_ = first_;
    latency_ = longest_ = bytes_ = 0;
    for (unsigned i = 0; i < readers_.size(); ++i) {
      Reader& reader = *readers_[i];
      reader.sent = reader.received = 0;
      reader.state = 0x9E3779B97F4A7C15u * (i + 1);
      reader.began.assign(pass.in_flight, 0);
      reader.free.clear();
      for (unsigned slot = 0; slot < pass.in_flight; ++slot) reader.free.push_back(slot);
    }
    alarm_.request(first_);
  }
  bool finished() const {
    return std::all_of(readers_.begin(), readers_.end(),
                       [this](const auto& r) { return r->received == pass_.requests && r->initiator.idle(); });
  }

  Cycle tick(Cycle now) override {
    Cycle due = kNever;
    for (unsigned i = 0; i < readers_.size(); ++i) {
      Reader& reader = *readers_[i];
      reader.initiator.update(now);
      while (const modules::AtInitiator::Completion* done = reader.initiator.front(now)) {
        if (!done->ok()) throw Error("dram_bandwidth", fmt::format("address {}", done->address), "was refused");
        const Cycle waited = now - reader.began[done->context];
        latency_ += waited;
        longest_ = std::max(longest_, waited);
        bytes_ += options_.bytes;
        last_ = now;
        ++reader.received;
        reader.free.push_back(done->context);
        reader.initiator.pop();
      }
      if (reader.sent < pass_.requests && !reader.free.empty()) {
        if (reader.initiator.can_send(now)) {
          send(reader, i, now);
          due = std::min(due, now + 1);
        } else {
          due = std::min(due, reader.initiator.next_send());
        }
      }
      due = std::min(due, reader.initiator.next_visible());
    }
    return due;
  }

  void print(double peak) const {
    const double ns = static_cast<double>(last_ - first_) * static_cast<double>(clock_.period_fs()) * 1e-6;
    const double to_ns = static_cast<double>(clock_.period_fs()) * 1e-6;
    const double bandwidth = static_cast<double>(bytes_) / ns;
    const double requests = static_cast<double>(bytes_ / options_.bytes);
    fmt::print("{:<10} {:<10} {:>5} {:>9} {:>9.2f} {:>8.1f} {:>10.1f} {:>10.1f} {:>10.0f}\n", options_.model,
               pass_.name, options_.bytes, pass_.in_flight, bandwidth, peak > 0 ? 100.0 * bandwidth / peak : 0.0,
               static_cast<double>(latency_) / requests * to_ns, static_cast<double>(longest_) * to_ns,
               1e9 * (bench::cpu_seconds() - began_) / requests);
  }

 private:
  struct Reader {
    Reader(const std::string& name, modules::ClockDomain& clock) : initiator(name.c_str(), clock) {}
    modules::AtInitiator initiator;
    std::uint64_t sent = 0;
    std::uint64_t received = 0;
    std::uint64_t state = 0;          ///< of the random numbers
    std::uint64_t streamed = 0;       ///< local address
    std::vector<Cycle> began;         ///< [context]
    std::vector<std::uint32_t> free;  ///< contexts
  };

  static std::uint64_t random(std::uint64_t& state) {  // xorshift64*
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return state * 0x2545F4914F6CDD1Du;
  }

  void send(Reader& reader, unsigned slice, Cycle now) {
    const std::uint64_t size = options_.footprint / options_.slices;
    const bool write =
        options_.writes > 0 && static_cast<double>(random(reader.state) >> 11) * 0x1p-53 < options_.writes;
    std::uint64_t local = reader.streamed % size;
    if (pass_.pattern == Pattern::streaming) {
      reader.streamed += options_.bytes;
    } else {
      local = random(reader.state) % (size / options_.bytes) * options_.bytes;
    }
    const std::uint32_t context = reader.free.back();
    reader.free.pop_back();
    reader.began[context] = now;
    reader.initiator.send(interleave_.global(local, slice), options_.bytes, write, context);
    ++reader.sent;
  }

  Options options_;
  modules::AddressInterleave interleave_;
  std::vector<std::unique_ptr<Reader>> readers_;
  Pass pass_{};
  Cycle first_ = 0;
  Cycle last_ = 0;
  Cycle latency_ = 0;
  Cycle longest_ = 0;
  std::uint64_t bytes_ = 0;
  double began_ = 0.0;  ///< processor time
};

/// The model that is measured, bound to the readers.
class Memory {
 public:
  Memory(const Options& options, Readers& readers) {
    modules::AddressInterleave interleave;
    interleave.slices = options.slices;
    if (options.model == "built_in" || options.model == "perfect") {
      const sim::GpuConfig machine = sim::load_config(options.config, {});
      modules::DramConfig config = machine.dram;
      config.interleave = interleave;
      config.perfect = options.model == "perfect";
      clock_ = std::make_unique<modules::ClockDomain>("memory_clock", machine.memory_mhz);
      const double period_ns = static_cast<double>(clock_->period_fs()) * 1e-6;
      config.fixed_latency = static_cast<Cycle>(options.fixed_latency_ns / period_ns);
      built_in_ = std::make_unique<modules::Dram>("dram", config, *clock_);
      for (unsigned i = 0; i < options.slices; ++i) readers.initiator(i).socket.bind(built_in_->sockets[i]);
      peak_ = options.slices * config.channel.burst_bytes / (config.channel.timing.ccd * period_ns);
      return;
    }
    sim::PortedDramConfig config;
    config.file = options.config;
    config.interleave = interleave;
    config.per_slice = !options.shared;
    config.fixed_latency_fs = static_cast<std::uint64_t>(options.fixed_latency_ns * 1e6);
    ported_ = sim::build_dram_simulator(options.model, "dram", config);
    for (unsigned i = 0; i < options.slices; ++i) readers.initiator(i).socket.bind(ported_->port(i).socket);
  }

  double peak() const { return peak_; }  ///< GB/s; 0: not known
  bool idle() const { return built_in_ != nullptr ? built_in_->idle() : ported_->idle(); }
  void dump_state(std::ostream& out) const {
    if (ported_ != nullptr) ported_->dump_state(out);
    if (built_in_ != nullptr) built_in_->dump_state(out);
  }

 private:
  std::unique_ptr<modules::ClockDomain> clock_;
  std::unique_ptr<modules::Dram> built_in_;
  std::unique_ptr<sim::PortedDram> ported_;
  double peak_ = 0.0;
};

void measure(const Options& options) {
  modules::set_time_resolution_to_fs();
  modules::ClockDomain clock("clock", options.request_mhz);
  Readers readers("readers", options, clock);
  Memory memory(options, readers);
  const double peak = options.peak > 0 ? options.peak : memory.peak();
  const Pass passes[] = {{"dependent", Pattern::dependent, 1, std::min<std::uint64_t>(options.requests, 2000)},
                         {"streaming", Pattern::streaming, options.in_flight, options.requests},
                         {"random", Pattern::random, options.in_flight, options.requests}};
  fmt::print("peak {:.2f} GB/s, {} slices, requests at {:.0f} MHz\n", peak, options.slices, options.request_mhz);
  fmt::print("{:<10} {:<10} {:>5} {:>9} {:>9} {:>8} {:>10} {:>10} {:>10}\n", "model", "pattern", "bytes", "in flight",
             "GB/s", "% peak", "mean ns", "longest ns", "CPU ns");
  const sc_core::sc_time step = sc_core::sc_time(10, sc_core::SC_US);
  for (const Pass& pass : passes) {
    readers.begin(pass);
    for (unsigned steps = 0; !readers.finished() || !memory.idle(); ++steps) {
      if (steps == 100'000) {
        memory.dump_state(std::cerr);
        throw Error("dram_bandwidth", pass.name, "has not ended after one second of simulated time");
      }
      sc_core::sc_start(step);
    }
    readers.print(peak);
  }
}

}  // namespace

int sc_main(int argc, char** argv) {
  Options options;
  CLI::App app("Bandwidth and latency of a DRAM model against its peak");
  std::vector<std::string> models = grtx::sim::dram_simulators();
  models.insert(models.begin(), {"built_in", "perfect"});
  app.add_option("--model", options.model, "DRAM model")->check(CLI::IsMember(models));
  app.add_option("--config", options.config, "configuration file of the DRAM simulator, or of the built-in DRAM");
  app.add_flag("--shared", options.shared, "one memory for all slices in place of one each");
  app.add_option("--slices", options.slices, "readers, one a socket");
  app.add_option("--bytes", options.bytes, "of a request, a power of two up to 128");
  app.add_option("--in-flight", options.in_flight, "requests of a slice under way, streaming and random");
  app.add_option("--requests", options.requests, "of a slice and pattern");
  app.add_option("--footprint", options.footprint, "bytes that addresses are drawn from");
  app.add_option("--writes", options.writes, "share of writes, 0 to 1");
  app.add_option("--request-mhz", options.request_mhz, "clock of the readers, which send one request a clock at most");
  app.add_option("--peak", options.peak, "GB/s of all data buses; known for the built-in DRAM");
  app.add_option("--fixed-latency", options.fixed_latency_ns, "ns added to each response");
  try {
    app.parse(argc, argv);
    measure(options);
  } catch (const CLI::ParseError& e) {
    return app.exit(e);
  } catch (const grtx::Error& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
  return 0;
}
