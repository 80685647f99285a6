#include "grtx/modules/cache/decide/replacement.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "grtx/base/declare/named_enum.h"
#include "grtx/base/error.h"
#include "grtx/modules/cache/decide/policies/fifo.h"
#include "grtx/modules/cache/decide/policies/pseudo_random.h"

namespace grtx::modules {
namespace {

using Named = std::pair<std::string, CacheReplacementFactory>;

// The one list of names; what a program registers is there for its whole life.
std::vector<Named>& replacements() {
  static std::vector<Named> all = {
      {"lru", [](std::uint64_t, unsigned) { return nullptr; }},
      {"fifo", [](std::uint64_t sets, unsigned ways) { return std::make_unique<Fifo>(sets, ways); }},
      {"random", [](std::uint64_t sets, unsigned ways) { return std::make_unique<PseudoRandom>(sets, ways); }}};
  return all;
}

const CacheReplacementFactory* find_replacement(std::string_view name) {
  const auto found =
      std::find_if(replacements().begin(), replacements().end(), [&](const Named& each) { return each.first == name; });
  return found == replacements().end() ? nullptr : &found->second;
}

}  // namespace

void register_cache_replacement(const std::string& name, CacheReplacementFactory factory) {
  if (find_replacement(name) != nullptr) throw std::logic_error("the cache replacement " + name + " exists already");
  replacements().emplace_back(name, std::move(factory));
}

std::vector<std::string> cache_replacement_names() {
  std::vector<std::string> names;
  for (const Named& each : replacements()) names.push_back(each.first);
  return names;
}

std::unique_ptr<CacheReplacement> make_cache_replacement(std::string_view name, std::uint64_t sets, unsigned ways) {
  if (const CacheReplacementFactory* factory = find_replacement(name)) return (*factory)(sets, ways);
  throw Error("configuration", "cache replacement", unknown_name(name, cache_replacement_names()));
}

}  // namespace grtx::modules
