// SPDX-License-Identifier: Apache-2.0
#include "grtx/base/nearest_name.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace grtx {
namespace {

/// Edit distance with insertions, deletions, substitutions and swaps of neighbours. Returns `limit` if the distance is
/// not less, as soon as two successive rows show it.
std::size_t edit_distance(std::string_view a, std::string_view b, std::size_t limit) {
  if (std::max(a.size(), b.size()) - std::min(a.size(), b.size()) >= limit) return limit;
  std::vector<std::size_t> before(b.size() + 1), row(b.size() + 1), next(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  std::size_t least_before = 0;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t least = next[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      next[j] = std::min({row[j] + 1, next[j - 1] + 1, row[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        next[j] = std::min(next[j], before[j - 2] + 1);
      least = std::min(least, next[j]);
    }
    if (std::min(least, least_before) >= limit) return limit;
    least_before = least;
    before.swap(row);
    row.swap(next);
  }
  return row[b.size()];
}

std::vector<std::string_view> words_of(std::string_view key) {
  std::vector<std::string_view> words;
  for (std::size_t at = 0; at < key.size();) {
    const std::size_t end = std::min(key.find_first_of("._", at), key.size());
    if (end > at) words.push_back(key.substr(at, end - at));
    at = end + 1;
  }
  return words;
}

}  // namespace

std::string nearest_name(std::string_view name, const std::vector<std::string>& known) {
  constexpr std::size_t kLongest = 200;  // longer than any known name; bounds the time, the product of both lengths
  name = name.substr(0, kLongest);
  std::string best;
  std::size_t best_distance = std::numeric_limits<std::size_t>::max();
  for (const std::string& candidate : known) {
    const std::size_t distance = edit_distance(name, candidate, best_distance);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

std::string nearest_keys(std::string_view name, const std::vector<std::string>& known) {
  constexpr std::size_t kMost = 3, kLongest = 200;
  std::vector<std::string> found{nearest_name(name, known)};
  const std::vector<std::string_view> wanted = words_of(name.substr(0, kLongest));
  for (const std::string& key : known) {
    if (found.size() == kMost) break;
    const std::vector<std::string_view> own = words_of(key);
    const auto has = [&](std::string_view word) { return std::ranges::find(own, word) != own.end(); };
    if (key != found.front() && wanted.size() > 1 && std::ranges::all_of(wanted, has)) found.push_back(key);
  }
  if (found.size() == 1) return "the nearest is '" + found.front() + "'";
  std::string text = "the nearest are '" + found.front() + "'";
  for (std::size_t i = 1; i < found.size(); ++i) text += (i + 1 == found.size() ? " and '" : ", '") + found[i] + "'";
  return text;
}

}  // namespace grtx
