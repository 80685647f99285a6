// SPDX-License-Identifier: Apache-2.0
// Wraps a source of ray groups. Of each group that is fetched it adds up the totals that the hardware must execute, and
// keeps the longest dependent chain; the checks at the end of a run compare with both.
#pragma once

#include <algorithm>
#include <exception>

#include "grtx/modules/simt/work_distributor_if.h"
#include "grtx/rtl_tlm/run/ray_chain.h"
#include "grtx/traces/count_totals.h"

namespace grtx::sim {

class MeasuredSource final : public modules::GroupSource {
 public:
  MeasuredSource(modules::GroupSource& source, const traces::Header& header, const ChainLatencies& latencies)
      : source_(source), header_(header), latencies_(latencies) {}

  std::uint64_t count() const override { return source_.count(); }
  const traces::RayGroup* acquire(std::uint64_t position) override {
    try {
      const traces::RayGroup* group = source_.acquire(position);
      traces::add_totals(totals_, traces::count_totals(header_, *group));
      const Chain chain = measure_chain(*group, latencies_);
      longest_.ray = std::max(longest_.ray, chain.ray);
      longest_.warp = std::max(longest_.warp, chain.warp);
      return group;
    } catch (...) {
      failure_ = std::current_exception();  // the kernel turns what a process throws into a report and loses its type
      throw;
    }
  }
  void release(std::uint64_t position) override { source_.release(position); }

  const traces::Header& header() const { return header_; }
  /// Totals and longest chains of all groups acquired so far.
  const traces::Totals& totals() const { return totals_; }
  const Chain& longest() const { return longest_; }
  /// The exception that acquire() threw, if any.
  const std::exception_ptr& failure() const { return failure_; }

 private:
  modules::GroupSource& source_;
  const traces::Header& header_;
  ChainLatencies latencies_;
  traces::Totals totals_;
  Chain longest_;
  std::exception_ptr failure_;
};

}  // namespace grtx::sim
