// Which of several designs no other beats, in any number of costs.
#pragma once

#include <vector>

namespace grtx::sim {

/// a is at most b in every cost, and less in one. Less is better.
bool dominates(const std::vector<double>& a, const std::vector<double>& b);

/// For each, whether no other dominates it; equals do not dominate each other. Empty ones, and those with a cost that
/// is not finite, take no part.
std::vector<bool> non_dominated(const std::vector<std::vector<double>>& costs);

}  // namespace grtx::sim
