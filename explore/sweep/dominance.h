// SPDX-License-Identifier: Apache-2.0
// Pareto dominance for any number of costs; less is better.
#pragma once

#include <vector>

namespace grtx::explore {

/// True if a is at most b in every cost and less in at least one.
bool dominates(const std::vector<double>& a, const std::vector<double>& b);

/// For each design, whether no other dominates it; equal designs do not dominate each other. False for designs without
/// costs or with a cost that is not finite; these dominate none.
std::vector<bool> non_dominated(const std::vector<std::vector<double>>& costs);

}  // namespace grtx::explore
