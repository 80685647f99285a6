// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/cache/decide/replacement.h"

#include <utility>

#include "grtx/modules/cache/decide/policies/fifo.h"
#include "grtx/modules/cache/decide/policies/pseudo_random.h"
#include "grtx/modules/kernel/declare.h"

namespace grtx::modules {
namespace {

constexpr const char* kLru = "lru";  ///< built into the tag array

auto& replacements() {
  static Registry<CacheReplacementFactory> all(
      "cache replacement", "cache replacement",
      {{kLru, {}},
       {"fifo", [](std::uint64_t sets, unsigned ways) { return std::make_unique<Fifo>(sets, ways); }},
       {"random", [](std::uint64_t sets, unsigned ways) { return std::make_unique<PseudoRandom>(sets, ways); }}});
  return all;
}

}  // namespace

void register_cache_replacement(const std::string& name, CacheReplacementFactory factory) {
  replacements().add(name, std::move(factory));
}

std::vector<std::string> cache_replacement_names() { return replacements().names(); }

std::unique_ptr<CacheReplacement> make_cache_replacement(std::string_view name, std::uint64_t sets, unsigned ways) {
  if (name == kLru) return nullptr;
  return replacements().make(name, sets, ways);
}

}  // namespace grtx::modules
