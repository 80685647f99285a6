#include "grtx/rtl_tlm/estimate/fast/fast_run.h"

#include <algorithm>
#include <utility>

#include "grtx/rtl_tlm/estimate/fast/fast_gpu.h"
#include "grtx/rtl_tlm/run/trace_source.h"

namespace grtx::sim {
namespace {

class NotingSource final : public modules::GroupSource {
 public:
  NotingSource(modules::GroupSource& source, const std::function<void(const traces::RayGroup&)>& acquired)
      : source_(source), acquired_(acquired) {}
  std::uint64_t count() const override { return source_.count(); }
  const traces::RayGroup* acquire(std::uint64_t position) override {
    const traces::RayGroup* group = source_.acquire(position);
    if (acquired_) acquired_(*group);
    return group;
  }
  void release(std::uint64_t position) override { source_.release(position); }

 private:
  modules::GroupSource& source_;
  const std::function<void(const traces::RayGroup&)>& acquired_;
};

/// Launches come in the order of the groups.
class Ends final : public modules::WarpObserver {
 public:
  Ends(FastRun& run, unsigned resident_warps) : run_(run), resident_warps_(resident_warps) {}
  void launched(unsigned sm, unsigned slot, const traces::RayGroup& /*group*/, Cycle /*now*/) override {
    const std::size_t place = std::size_t{sm} * resident_warps_ + slot;
    if (place >= running_.size()) running_.resize(place + 1);
    run_.group_sm[next_] = sm;
    running_[place] = next_++;
  }
  void ended(unsigned sm, unsigned slot, Cycle now) override {
    run_.group_end[running_[std::size_t{sm} * resident_warps_ + slot]] = now;
  }

 private:
  FastRun& run_;
  unsigned resident_warps_;
  std::vector<std::size_t> running_;  ///< position of the group in each warp slot
  std::size_t next_ = 0;
};

}  // namespace

FastRun run_fast(const traces::Reader& reader, const std::vector<std::uint64_t>& groups,
                 const std::vector<Launch>& known, const GpuConfig& config,
                 const std::function<void(const traces::RayGroup&)>& acquired) {
  FastRun run;
  run.group_end.resize(groups.size());
  run.group_sm.resize(groups.size());
  constexpr unsigned kDecodeAhead = 8;
  TraceSource file(reader, groups, kDecodeAhead);
  NotingSource source(file, acquired);
  const std::uint64_t visits =
      reader.totals().visits() * groups.size() / std::max<std::uint64_t>(1, reader.group_count());
  FastGpu gpu(config, reader.header(), reader.totals().max_evictions_per_ray, source, fast_stride(config, visits));
  Ends ends(run, config.resident_warps);
  gpu.observe(&ends);
  std::vector<unsigned> sms;
  for (const Launch& launch : known) sms.push_back(launch.sm);
  gpu.assign(std::move(sms));
  gpu.run([](std::uint64_t) {});
  run.counters = gpu.counters();
  return run;
}

}  // namespace grtx::sim
