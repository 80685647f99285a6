#include "grtx/rtl_tlm/estimate/fast/fast_gpu.h"

#include <algorithm>
#include <bit>
#include <string>
#include <utility>

#include "grtx/base/error.h"
#include "grtx/rtl_tlm/estimate/fast/fast_machine.h"
#include "grtx/rtl_tlm/gpu/mode_keys.h"

namespace grtx::sim {
namespace {

const GpuConfig& checked(const GpuConfig& config) {
  if (const Unmodelled lack = unmodelled(config, SimulationMode::fast)) {
    throw Error("configuration", std::string(lack.key), lack.rule);
  }
  return config;
}

}  // namespace

unsigned fast_stride(const GpuConfig& config, std::uint64_t visits) {
  constexpr std::uint64_t kTimedVisits = 500000, kLargest = 4;
  if (config.fast.stride != 0) return config.fast.stride;
  return static_cast<unsigned>(std::bit_floor(std::clamp<std::uint64_t>(visits / kTimedVisits, 1, kLargest)));
}

FastGpu::FastGpu(const GpuConfig& config, const traces::Header& header, std::uint64_t eviction_entries,
                 modules::GroupSource& source, unsigned stride)
    : machine_(std::make_unique<fast::Machine>(checked(config), header, eviction_entries, source, stride)) {}
FastGpu::~FastGpu() = default;

void FastGpu::observe(modules::WarpObserver* observer) { machine_->observe(observer); }
void FastGpu::assign(std::vector<unsigned> sms) { machine_->assign(std::move(sms)); }
void FastGpu::keep(FastGpu& before) { machine_->keep(*before.machine_); }
void FastGpu::save(StateWriter& state) const { machine_->save(state); }
void FastGpu::load(StateReader& state) { machine_->load(state); }
void FastGpu::run(const std::function<void(std::uint64_t)>& progress) { machine_->run(progress); }
GpuCounters FastGpu::counters() const { return machine_->counters(); }
bool FastGpu::idle() const { return machine_->idle(); }
std::uint64_t FastGpu::steps() const { return machine_->steps(); }

}  // namespace grtx::sim
