// SMs on threads of their own: which SM is on which thread, the links that cross, and how far an SM may be ahead of the
// memory side (clock_threads.h says how threads keep in step). No hardware.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "grtx/modules/kernel/clock_threads.h"
#include "grtx/modules/kernel/crossing_link.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/noc/crossbar_if.h"
#include "grtx/modules/simt/work_distributor_if.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {

class Sm;
struct BuildOptions;

/// The thread of each SM, 0 being the kernel's: it gets as many as the memory side leaves room for.
std::vector<unsigned> threads_of_sms(unsigned sms, unsigned threads);

/// The kernel's thread keeps distributor, crossbar, L2, DRAM and the first few SMs; the others are shared out.
class SmThreads {
 public:
  SmThreads(const GpuConfig& config, modules::ClockDomain& core, const BuildOptions& build);

  /// Of an SM's modules.
  modules::ClockDomain& clock(unsigned sm) { return thread_of_[sm] == 0 ? core_ : *clocks_[thread_of_[sm] - 1]; }
  /// groups: that the distributor will launch.
  void watch(const modules::WorkDistributorModule& distributor, std::uint64_t groups);
  /// Binds an SM to the rest of the GPU by links that cross threads; false: it is on the kernel's thread.
  bool bind(unsigned index, Sm& sm, modules::WorkDistributorModule& distributor, modules::CrossbarModule& crossbar);
  bool links_empty() const;
  std::uint64_t messages() const;  ///< sent so far, over all links that cross

 private:
  struct Links {
    Links(const GpuConfig& config, const modules::ThreadProgress& kernel, const modules::ThreadProgress& own,
          modules::Patience patience, std::size_t ahead);
    modules::CrossingLink<modules::LaunchWarp> launch;
    modules::CrossingLink<modules::WarpEnded> ended;
    modules::CrossingLink<modules::MemoryRequest> request;
    modules::CrossingLink<modules::MemoryResponse> response;
  };
  struct Thread {
    std::vector<const Links*> sms;
    bool all_launched = false;  ///< as of the look before the last
  };
  Cycle reach(Thread& thread) const;

  const GpuConfig config_;
  modules::ClockDomain& core_;
  std::vector<unsigned> thread_of_;  ///< by SM; 0: the kernel's
  modules::Patience patience_;
  std::size_t ahead_ = 0;  ///< responses that may be sent before their cycle
  std::vector<std::unique_ptr<modules::ClockDomain>> clocks_;
  std::vector<std::unique_ptr<Thread>> threads_;
  std::vector<std::unique_ptr<Links>> links_;  ///< by SM; none for those on the kernel's thread
  std::atomic<bool> all_launched_{false};
  modules::ClockThreads running_;  ///< last: its threads end first
};

}  // namespace grtx::sim
