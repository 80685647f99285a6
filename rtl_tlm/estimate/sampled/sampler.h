// Which groups a sample holds: all groups are dealt out to classes of equal make-up, and samples are classes.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/rtl_tlm/estimate/sampled/group_work.h"

namespace grtx::sim {

/// Deals the groups out to `classes` classes: groups are ranked by kind, by the number of k-buffer entries that they
/// processed and by index, and of every `classes` neighbours in that ranking each class gets one, by lot. Every group
/// is in exactly one class, with probability 1 / classes in any given one, so class totals times `classes` are
/// unbiased. What is ranked by does not depend on the acceleration structure or on checkpointing: traces of one view
/// with the same k are dealt out alike. Ascending indices. The same seed gives the same classes on every machine.
std::vector<std::vector<std::uint64_t>> deal_classes(const std::vector<GroupWork>& groups, unsigned classes,
                                                     std::uint64_t seed);

}  // namespace grtx::sim
