// Runs SMs with clocks of their own on several host threads: the links between threads, and how far an SM may be ahead
// of the memory side (clock_threads.h has the protocol). No hardware.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "grtx/modules/kernel/clock_threads.h"
#include "grtx/modules/kernel/crossing_link.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/simt/work_distributor.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {

struct BuildOptions;

/// Initial thread of each SM. Thread 0 is the kernel's, which also steps the memory side and so gets fewer SMs.
std::vector<unsigned> threads_of_sms(unsigned sms, unsigned threads);

/// The kernel's thread steps distributor, crossbar, L2 and DRAM; any thread steps an SM.
class SmThreads {
 public:
  /// Whether threads are possible: a link of less capacity could block a response, and the crossbar would have to wait
  /// for the SM in the middle of a cycle.
  static bool possible(const GpuConfig& config) { return config.links.capacity > config.links.latency; }
  SmThreads(const GpuConfig& config, modules::ClockDomain& core, const BuildOptions& build);

  /// The links between an SM and the rest of the GPU, across threads.
  struct Links final : modules::ClockThreads::Coupling {
    Links(const SmThreads& of, const modules::ThreadProgress& kernel, const modules::ThreadProgress& own);
    modules::CrossingLink<modules::LaunchWarp> launch;
    modules::CrossingLink<modules::WarpEnded> ended;
    modules::CrossingLink<modules::MemoryRequest> request;
    modules::CrossingLink<modules::MemoryResponse> response;
    void collect() override;
    void collect_for_leader() override;
    Cycle reach() const override;
    bool knows_room(Cycle cycle) const override;
    const SmThreads& threads;
    bool all_launched = false;
  };
  Links& links(unsigned sm) { return *links_[sm]; }
  /// Calls f(link) for each link that crosses threads.
  template <typename F>
  void for_each_link(F&& f) const {
    for (const auto& l : links_) {
      f(l->launch);
      f(l->ended);
      f(l->request);
      f(l->response);
    }
  }

  /// The clock of an SM's modules.
  modules::ClockDomain& clock(unsigned sm) { return *clocks_[sm]; }
  /// groups: number that the distributor will launch.
  void watch(const modules::WorkDistributorModule& distributor, std::uint64_t groups);
  Cycle latest() const;  ///< ClockDomain::latest() of all SMs
  /// Whether the kernel's thread had to step all SMs for a while.
  bool rested() const { return running_.rested(); }

 private:
  const GpuConfig config_;
  const Cycle response_reach_;
  std::vector<std::unique_ptr<modules::ClockDomain>> clocks_;  ///< by SM
  std::vector<std::unique_ptr<Links>> links_;                  ///< by SM
  std::atomic<bool> all_launched_{false};
  modules::ClockThreads running_;  ///< last: its threads end first
};

}  // namespace grtx::sim
