// Fast mode as an engine of simulate(): the same decisions, loosely timed, in a fraction of the time.
#pragma once

#include <string>
#include <vector>

#include "grtx/rtl_tlm/estimate/fast/measured_region.h"
#include "grtx/rtl_tlm/run/first_launches.h"
#include "grtx/rtl_tlm/run/simulation.h"

namespace grtx::sim {

/// No waveforms, timelines or cycles by pixel: asking for them is an Error.
class FastEngine final : public Engine {
 public:
  std::string name() const override { return "fast"; }
  void prepare(const Work& work) override;
  FinishedRun run(const Work& work, modules::GroupSource& source) override;
  void describe(modules::StatisticList& list) const override;
  ResultNotes notes() const override { return outside_notes(name(), outside_); }
  bool estimates() const override { return stride_ > 1; }

 private:
  /// Which SMs the first groups go to in cycle mode; nowhere in particular where all are launched at once.
  static std::vector<unsigned> first_sms(const traces::Reader& reader, const std::vector<std::uint64_t>& groups,
                                         const GpuConfig& config);

  std::vector<unsigned> first_, first_before_;  ///< of the trace, and of the one that runs before
  unsigned stride_ = 1;
  std::string outside_;
};

}  // namespace grtx::sim
