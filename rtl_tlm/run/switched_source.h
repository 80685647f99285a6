// SPDX-License-Identifier: Apache-2.0
// A group source whose trace changes between launches.
#pragma once

#include "grtx/modules/simt/work_distributor_if.h"

namespace grtx::sim {

class SwitchedSource final : public modules::GroupSource {
 public:
  SwitchedSource() = default;  ///< without groups
  explicit SwitchedSource(modules::GroupSource& source) : source_(&source) {}

  /// From now on the groups come from `source`, which must outlive their use; nullptr: no groups. Call only while all
  /// groups are released, and before the distributor restarts.
  void switch_to(modules::GroupSource* source) { source_ = source; }

  std::uint64_t count() const override { return source_ == nullptr ? 0 : source_->count(); }
  const traces::RayGroup* acquire(std::uint64_t position) override { return source_->acquire(position); }
  void release(std::uint64_t position) override { source_->release(position); }

 private:
  modules::GroupSource* source_ = nullptr;
};

}  // namespace grtx::sim
