// What more threads than the host has cores would give: runs a trace on one thread, takes the time of each call of a
// unit, and plays the rules of ClockThreads with these times, as if each thread had a core of its own.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>
#include <systemc>
#include <utility>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/rtl_tlm/gpu/built_in_memory.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/sm_threads.h"
#include "grtx/rtl_tlm/run/simulation.h"

namespace {

using grtx::Cycle;
using grtx::modules::ClockDomain;
using grtx::modules::Clocked;

// A call that took longer was interrupted by something else on the host.
constexpr double kInterruptedNs = 200'000.0;

struct Options {
  std::string trace;
  std::string config;
  std::vector<std::string> settings;
  std::vector<unsigned> threads{2, 4, 8, 16};
  double handoff_ns = 100.0;
};

double now_ns() {
  return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// What taking the time of nothing gives.
double clock_cost_ns() {
  std::vector<double> costs(10'001);
  for (double& cost : costs) {
    const double start = now_ns();
    cost = now_ns() - start;
  }
  std::nth_element(costs.begin(), costs.begin() + 5'000, costs.end());
  return costs[5'000];
}

/// The times at which so many threads would have done each cycle.
class Threads {
 public:
  Threads(const grtx::sim::GpuConfig& config, unsigned threads, double handoff_ns)
      : thread_of_(grtx::sim::threads_of_sms(config.sms, threads)),
        lag_(std::min(config.links.latency, config.sm_links.message_latency)),
        reach_(std::max(config.crossbar.latency, config.links.latency)),
        handoff_ns_(handoff_ns),
        work_(thread_of_.back() + 1),
        sum_(work_.size()),
        waited_(work_.size()),
        done_(work_.size()) {}

  /// cost: of each SM, then of all that stays with the kernel. own: of stepping a clock, which each thread pays.
  void cycle(Cycle cycle, const std::vector<double>& cost, double own) {
    // Nothing was due in between.
    for (Cycle idle = std::max(last_ + 1, cycle - std::min(cycle, kWindow)); idle < cycle; ++idle) {
      for (auto& done : done_) done[idle % kWindow] = done[last_ % kWindow];
    }
    std::fill(work_.begin(), work_.end(), own);
    for (std::size_t sm = 0; sm < thread_of_.size(); ++sm) work_[thread_of_[sm]] += cost[sm];
    work_[0] += cost.back();
    // Followers come first: a leader's cycle waits for theirs, `lag` before it.
    for (std::size_t t = work_.size(); t-- > 0;) {
      double start = done_[t][last_ % kWindow];
      if (t > 0 && cycle >= reach_) start = std::max(start, done_[0][(cycle - reach_) % kWindow] + handoff_ns_);
      if (t == 0 && cycle >= lag_) {
        for (std::size_t f = 1; f < work_.size(); ++f) {
          start = std::max(start, done_[f][(cycle - lag_) % kWindow] + handoff_ns_);
        }
      }
      waited_[t] += start - done_[t][last_ % kWindow];
      done_[t][cycle % kWindow] = start + work_[t];
      sum_[t] += work_[t];
    }
    last_ = cycle;
    if (cycle / kBalance != balanced_) balance(cycle / kBalance);
  }

  std::size_t used() const { return work_.size(); }
  double total_ns() const {
    double last = 0.0;
    for (const auto& done : done_) last = std::max(last, done[last_ % kWindow]);
    return last;
  }
  double busiest_ns() const { return *std::max_element(sum_.begin(), sum_.end()); }
  double leader_ns() const { return sum_[0]; }

 private:
  static constexpr Cycle kWindow = 1024;    // more than any latency
  static constexpr Cycle kBalance = 65536;  // a run stands still so often

  // As ClockThreads does.
  void balance(Cycle period) {
    balanced_ = period;
    std::vector<std::size_t> owned(work_.size());
    for (const unsigned t : thread_of_) ++owned[t];
    std::size_t most = 0, least = work_.size();
    for (std::size_t t = 0; t < work_.size(); ++t) {
      if (waited_[t] > waited_[most]) most = t;
      const bool gives = owned[t] > (t == 0 ? 0U : 1U);
      if (gives && (least == work_.size() || waited_[t] < waited_[least])) least = t;
    }
    if (least != work_.size() && waited_[least] < waited_[most]) {
      *std::find(thread_of_.rbegin(), thread_of_.rend(), least) = static_cast<unsigned>(most);
    }
    std::fill(waited_.begin(), waited_.end(), 0.0);
  }

  std::vector<unsigned> thread_of_;
  Cycle lag_, reach_;
  double handoff_ns_;
  std::vector<double> work_, sum_;                 ///< by thread
  std::vector<double> waited_;                     ///< by thread, since the last balance()
  std::vector<std::array<double, kWindow>> done_;  ///< by thread
  Cycle last_ = 0;
  Cycle balanced_ = 0;
};

/// The time of each cycle by part: each SM, then the kernel's thread's.
class Ledger {
 public:
  Ledger(const grtx::sim::GpuConfig& config, const Options& options) : cost_(config.sms + 1) {
    for (const unsigned threads : options.threads) projections_.emplace_back(config, threads, options.handoff_ns);
  }

  std::size_t memory_side() const { return cost_.size() - 1; }
  /// Notes a call in a cycle of the core clock; the memory clock's calls belong to the core cycle before them.
  void begin(Cycle core_cycle) {
    if (core_cycle == cycle_) return;
    const double now = now_ns();
    if (started_) close(now);
    cycle_ = core_cycle;
    start_ = now;
    started_ = true;
    std::fill(cost_.begin(), cost_.end(), 0.0);
    taken_ = 0.0;
  }
  void add(std::size_t part, double ns) {
    const double own = ns - clock_cost_;
    taken_ += ns + clock_cost_;
    if (ns > kInterruptedNs) {
      interrupted_ += ns;
    } else {
      cost_[part] += std::max(own, 0.0);
    }
  }
  void report() {
    close(now_ns());
    double one = own_;
    for (const double ns : sum_) one += ns;
    const auto [least, most] = std::minmax_element(sum_.begin(), sum_.end() - 1);
    const double sms = one - own_ - sum_.back();
    fmt::print("{} cycles with work, {:.2f} us each: SMs {:.1f} %, memory side {:.1f} %, stepping the clock {:.1f} %\n",
               cycles_, one / 1e3 / static_cast<double>(cycles_), 100.0 * sms / one, 100.0 * sum_.back() / one,
               100.0 * own_ / one);
    fmt::print("the SM with the most work has {:.3f} times the mean, that with the least {:.3f}\n",
               *most * static_cast<double>(memory_side()) / sms, *least * static_cast<double>(memory_side()) / sms);
    fmt::print("left out as interrupted: {:.2f} %\n", 100.0 * interrupted_ / (one + interrupted_));
    fmt::print("threads  speed  busiest thread alone  of it waiting  kernel's thread's work\n");
    for (const Threads& p : projections_) {
      fmt::print("{:7}  {:5.2f}  {:20.2f}  {:11.1f} %  {:20.1f} %\n", p.used(), one / p.total_ns(),
                 one / p.busiest_ns(), 100.0 * (1.0 - p.busiest_ns() / p.total_ns()),
                 100.0 * p.leader_ns() / p.total_ns());
    }
  }

 private:
  void close(double now) {
    double own = now - start_ - taken_;
    if (own > kInterruptedNs) {
      interrupted_ += own;
      own = 0.0;
    }
    own = std::max(own, 0.0);
    own_ += own;
    for (std::size_t i = 0; i < cost_.size(); ++i) sum_[i] += cost_[i];
    for (Threads& p : projections_) p.cycle(cycle_, cost_, own);
    ++cycles_;
    start_ = now_ns();
  }

  std::vector<double> cost_;
  std::vector<double> sum_ = std::vector<double>(cost_.size());
  std::vector<Threads> projections_;
  const double clock_cost_ = clock_cost_ns();
  bool started_ = false;
  Cycle cycle_ = 0;
  std::uint64_t cycles_ = 0;
  double start_ = 0.0, taken_ = 0.0;  ///< of the present cycle
  double own_ = 0.0, interrupted_ = 0.0;
};

/// Stands between a clock and a unit.
class Meter final : public Clocked {
 public:
  Meter(Clocked& unit, std::size_t part, Ledger& ledger, const ClockDomain& core)
      : unit_(unit), part_(part), ledger_(ledger), core_(core) {}
  virtual ~Meter() = default;
  Cycle tick(Cycle now) override {
    ledger_.begin(core_.cycle());
    const double start = now_ns();
    const Cycle next = unit_.tick(now);
    ledger_.add(part_, now_ns() - start);
    return next;
  }

 private:
  Clocked& unit_;
  std::size_t part_;
  Ledger& ledger_;
  const ClockDomain& core_;
};

/// The SM that a unit belongs to, by its name in the hierarchy; memory_side: none.
std::size_t part_of(const Clocked& unit, std::size_t memory_side) {
  const auto* object = dynamic_cast<const sc_core::sc_object*>(&unit);
  if (object == nullptr) return memory_side;  // the crossbar's networks
  const std::string name = object->name();
  constexpr std::string_view kSm = "gpu.sm";
  if (!name.starts_with(kSm)) return memory_side;
  return std::stoul(name.substr(kSm.size()));
}

void run(const Options& options) {
  using namespace grtx::sim;
  const GpuConfig config = load_config(options.config, options.settings);
  Ledger ledger(config, options);
  std::vector<std::unique_ptr<Meter>> meters;
  SimulationOptions simulation;
  simulation.memory = [&](Gpu& gpu, const BuildOptions& build) {
    auto memory = std::make_unique<BuiltInMemory>(gpu, build);
    const auto between = [&](Clocked& unit) -> Clocked& {
      meters.push_back(
          std::make_unique<Meter>(unit, part_of(unit, ledger.memory_side()), ledger, std::as_const(gpu).core()));
      return *meters.back();
    };
    gpu.core().put_between(between);
    memory->clock().put_between(between);
    return memory;
  };
  const SimulationResult result = simulate(options.trace, config, simulation);
  if (!result.violations.empty()) throw grtx::Error(options.trace, "simulation", result.violations.front());
  fmt::print("{}: {} cycles, {} SMs, {} ns from thread to thread\n", options.trace, result.cycles, config.sms,
             options.handoff_ns);
  ledger.report();
}

}  // namespace

int main(int argc, char** argv) {
  setenv("SYSTEMC_DISABLE_COPYRIGHT_MESSAGE", "1", 1);  // read by the kernel before it calls sc_main
  return sc_core::sc_elab_and_sim(argc, argv);
}

int sc_main(int argc, char* argv[]) {
  Options options;
  CLI::App app("Projects the speed of more threads than the host has cores");
  app.add_option("TRACE", options.trace, "Trace")->required();
  app.add_option("--config", options.config, "Configuration file");
  app.add_option("--set", options.settings, "key=value; repeatable")->allow_extra_args(false);
  app.add_option("--threads", options.threads, "Counts of threads")->delimiter(',')->check(CLI::Range(2, 256));
  app.add_option("--handoff-ns", options.handoff_ns, "From one core's store to another's load")
      ->check(CLI::NonNegativeNumber);
  CLI11_PARSE(app, argc, argv);
  try {
    run(options);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "thread_projection: {}\n", error.what());
    return 2;
  }
}
