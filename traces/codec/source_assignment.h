// Which entry of the source checkpoint buffer each read of a replay round means, when the buffer is read nearest first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "grtx/traces/codec/group_model.h"
#include "grtx/traces/event.h"

namespace grtx::traces {

/// Events name a source entry by its address alone, and the shared BLAS gives many entries one address. A take also
/// names the instances (the visit_instance events that follow it), a forward does not: so takes choose first, each the
/// first unread entry of its address and instances, then forwards get the first ones left of their address. Forwards
/// that swap instances among themselves do not matter, because a nearest-first buffer has no order.
class SourceAssignment {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;

  /// For the reads of one round, in order: position in `source`, or kNone when no unread entry has the address.
  /// `addresses` are those of the source entries.
  const std::vector<std::uint32_t>& assign(std::span<const std::uint32_t> addresses,
                                           const std::vector<NodeReference>& source, std::span<const Event> events,
                                           const InstanceLevels& levels);

 private:
  std::uint32_t claim(const std::vector<NodeReference>& source, std::uint32_t address, const InstancePath* path);

  std::vector<std::pair<std::uint32_t, std::uint32_t>> by_address_;  ///< address, position
  std::vector<bool> claimed_;
  std::vector<std::uint32_t> positions_;
};

}  // namespace grtx::traces
