#include "grtx/rtl_tlm/gpu/sm_threads.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <thread>

#include "grtx/rtl_tlm/gpu/gpu.h"
#include "grtx/rtl_tlm/gpu/sm.h"

namespace grtx::sim {
namespace {

// What crossbar, L2 and DRAM take, over what all SMs take: about a third of a run's time (docs/notes/threads.md).
constexpr double kMemoryShare = 0.5;

}  // namespace

std::vector<unsigned> threads_of_sms(unsigned sms, unsigned threads) {
  const double share = sms * (1.0 + kMemoryShare) / threads;
  const auto first = static_cast<unsigned>(std::clamp(std::lround(share - sms * kMemoryShare), 0L, long{sms} - 1));
  const unsigned followers = std::min(threads - 1, sms - first);
  std::vector<unsigned> thread_of(sms, 0);
  for (unsigned i = first; i < sms; ++i) thread_of[i] = 1 + (i - first) * followers / (sms - first);
  return thread_of;
}

SmThreads::Links::Links(const GpuConfig& config, const modules::ThreadProgress& kernel,
                        const modules::ThreadProgress& own, modules::Patience patience, std::size_t ahead)
    : launch(config.sm_links.message_latency, config.resident_warps, own, patience),
      ended(config.sm_links.message_latency, config.resident_warps, kernel, patience),
      request(config.links.latency, config.links.capacity, kernel, patience),
      response(config.links.latency, config.links.capacity, own, patience, ahead) {}

SmThreads::SmThreads(const GpuConfig& config, modules::ClockDomain& core, const BuildOptions& build)
    : config_(config),
      core_(core),
      thread_of_(threads_of_sms(config.sms, build.threads)),
      links_(config.sms),
      running_(core, std::min(config.links.latency, config.sm_links.message_latency)) {
  assert(build.run_ahead && build.threads > 1);
  // Our own L1 takes each response in the cycle in which it comes; a link of one place would still hold it up.
  if (!build.parts.sm.l1_cache && !build.parts.crossbar && config.links.capacity > config.links.latency) {
    ahead_ = std::size_t{config.crossbar.latency} + config.crossbar.output_buffer;
  }
  const unsigned followers = thread_of_.back();
  if (std::thread::hardware_concurrency() <= followers) patience_.spins = 0;
  running_.be_patient(patience_);
  for (unsigned t = 0; t < followers; ++t) {
    clocks_.push_back(std::make_unique<modules::ClockDomain>(fmt::format("core_clock_{}", t + 1).c_str(),
                                                             config.core_mhz, build.idle_skip));
    threads_.push_back(std::make_unique<Thread>());
    running_.follow(*clocks_[t], [this, &thread = *threads_[t]] { return reach(thread); });
  }
}

void SmThreads::watch(const modules::WorkDistributorModule& distributor, std::uint64_t groups) {
  running_.stop_when([this, &distributor, groups] {
    if (distributor.launched() == groups) all_launched_.store(true, std::memory_order_release);
    return distributor.finished();
  });
}

bool SmThreads::bind(unsigned index, Sm& sm, modules::WorkDistributorModule& distributor,
                     modules::CrossbarModule& crossbar) {
  if (thread_of_[index] == 0) return false;
  const unsigned follower = thread_of_[index] - 1;
  links_[index] =
      std::make_unique<Links>(config_, running_.leader_progress(), running_.progress(follower), patience_, ahead_);
  Links& links = *links_[index];
  distributor.launch[index].bind(links.launch);
  distributor.ended[index].bind(links.ended);
  sm.launch.bind(links.launch);
  sm.ended.bind(links.ended);
  sm.to_memory.bind(links.request);
  sm.from_memory.bind(links.response);
  crossbar.request_in[index].bind(links.request);
  crossbar.response_out[index].bind(links.response);
  running_.add_leader_inbox(links.ended);
  running_.add_leader_inbox(links.request);
  running_.add_inbox(follower, links.launch);
  running_.add_inbox(follower, links.response);
  threads_[follower]->sms.push_back(&links);
  return true;
}

// A response is sent as soon as it has won the arbitration, and is under way for as long as the crossbar takes. A warp
// can only come to an SM with a free slot. An SM without warps keeps in step, so that it has not gone on when the run
// ends.
Cycle SmThreads::reach(Thread& thread) const {
  // Launches that were sent before the look at the flag have been collected by the next call.
  const bool all_launched = thread.all_launched;
  thread.all_launched = all_launched_.load(std::memory_order_acquire);
  bool busy = false, may_launch = false;
  for (const Links* sm : thread.sms) {
    const std::uint64_t warps = sm->launch.collected() - sm->ended.pushed();
    busy = busy || warps > 0;
    may_launch = may_launch || (warps < config_.resident_warps && !all_launched);
  }
  if (!busy) return 1;
  const Cycle response =
      ahead_ != 0 ? std::max(config_.crossbar.latency, config_.links.latency) : config_.links.latency;
  return may_launch ? std::min<Cycle>(response, config_.sm_links.message_latency) : response;
}

bool SmThreads::links_empty() const {
  return std::all_of(links_.begin(), links_.end(), [](const auto& l) {
    return !l || (l->launch.empty() && l->ended.empty() && l->request.empty() && l->response.empty());
  });
}

std::uint64_t SmThreads::messages() const {
  std::uint64_t sum = 0;
  for (const auto& l : links_) {
    if (l) sum += l->launch.pushed() + l->ended.pushed() + l->request.pushed() + l->response.pushed();
  }
  return sum;
}

}  // namespace grtx::sim
