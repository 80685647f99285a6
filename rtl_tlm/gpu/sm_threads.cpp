#include "grtx/rtl_tlm/gpu/sm_threads.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "grtx/rtl_tlm/gpu/gpu.h"

namespace grtx::sim {
namespace {

// Host time of crossbar, L2 and DRAM over that of all SMs: they take about a third of a run (docs/notes/threads.md).
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

// Our own L1 takes each response in the cycle in which it comes.
SmThreads::Links::Links(const SmThreads& of, const modules::ThreadProgress& kernel, const modules::ThreadProgress& own)
    : launch(of.config_.sm_links.message_latency, of.config_.resident(), own),
      ended(of.config_.sm_links.message_latency, of.config_.resident(), kernel),
      request(of.config_.links.latency, of.config_.links.capacity, kernel),
      response(of.config_.links.latency, of.config_.links.capacity, own,
               std::size_t{of.config_.crossbar.latency} + of.config_.crossbar.output_buffer),
      threads(of) {}

SmThreads::SmThreads(const GpuConfig& config, modules::ClockDomain& core, const BuildOptions& build)
    : config_(config),
      response_reach_(std::max(config.crossbar.latency, config.links.latency)),
      running_(core, std::min(config.links.latency, config.sm_links.message_latency),
               threads_of_sms(config.sms, build.threads).back()) {
  assert(build.run_ahead && build.threads > 1 && possible(config));
  const std::vector<unsigned> thread_of = threads_of_sms(config.sms, build.threads);
  if (build.crowded) running_.judge_by(build.crowded);
  for (unsigned sm = 0; sm < config.sms; ++sm) {
    clocks_.push_back(std::make_unique<modules::ClockDomain>(fmt::format("core_clock_{}", sm).c_str(), config.core_mhz,
                                                             build.idle_skip));
    const modules::ThreadProgress& own = running_.follow(*clocks_[sm], thread_of[sm]);
    links_.push_back(std::make_unique<Links>(*this, running_.leader_progress(), own));
    running_.couple(sm, *links_[sm]);
  }
}

void SmThreads::watch(const modules::WorkDistributorModule& distributor, std::uint64_t groups) {
  running_.stop_when([this, &distributor, groups] {
    if (distributor.launched() == groups) all_launched_.store(true, std::memory_order_release);
    return distributor.finished();
  });
}

// Reads the flag before it collects, so that no launch sent before the flag was set is missed.
void SmThreads::Links::collect() {
  if (!all_launched) {
    all_launched = threads.all_launched_.load(std::memory_order_acquire);
    launch.collect();
  }
  response.collect();
}

void SmThreads::Links::collect_for_leader() {
  ended.collect();
  request.collect();
}

// How far the SM may run ahead. A response is sent when it wins arbitration and is under way for the crossbar's
// latency; a warp can only come to an SM with a free slot. An SM without warps stays in step, so that it is not ahead
// when the run ends.
Cycle SmThreads::Links::reach() const {
  const std::uint64_t warps = launch.collected() - ended.pushed();
  if (warps == 0) return 1;
  const bool may_launch = warps < threads.config_.resident() && !all_launched;
  return may_launch ? std::min(threads.response_reach_, Cycle{launch.latency()}) : threads.response_reach_;
}

// Our own L1 sends at most one request per cycle; messages of ended warps always find room.
bool SmThreads::Links::knows_room(Cycle cycle) const { return request.knows_room(cycle); }

Cycle SmThreads::latest() const {
  Cycle latest = 0;
  for (const auto& clock : clocks_) latest = std::max(latest, clock->latest());
  return latest;
}

}  // namespace grtx::sim
