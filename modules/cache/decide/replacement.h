// Which line of a set a cache gives up: a policy, free of SystemC, chosen by its name. `lru` is built into the tags,
// where the model spends its time; the others stand in policies/, one file each. One of your own is registered before
// the first cache is made.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "grtx/base/state_bytes.h"

namespace grtx::modules {

class CacheReplacement {
 public:
  virtual ~CacheReplacement() = default;
  /// A line was placed into `way`; empty ways are filled first, lowest first. Another than victim(): its line is dirty
  /// and had no way out, and this is the next clean one round the set.
  virtual void filled(std::uint64_t set, unsigned way) = 0;
  /// A line was hit.
  virtual void referenced(std::uint64_t set, unsigned way) = 0;
  /// The way that the next line of a full set replaces. The same answer until filled() is called for the set: a cache
  /// may look twice.
  virtual unsigned victim(std::uint64_t set) const = 0;
  /// State that hardware keeps for it, a line.
  virtual unsigned bits_per_line() const = 0;
  /// All that it knows, for a run in another process; false: it does not say.
  virtual bool save(StateWriter&) const { return false; }
  virtual void load(StateReader&) {}
};

using CacheReplacementFactory = std::function<std::unique_ptr<CacheReplacement>(std::uint64_t sets, unsigned ways)>;

/// Makes `name` a value of l1.replacement and l2.replacement. Throws std::logic_error when it is one already.
void register_cache_replacement(const std::string& name, CacheReplacementFactory factory);
/// lru and all others.
std::vector<std::string> cache_replacement_names();
/// nullptr for lru. Throws Error that lists the names for an unknown one.
std::unique_ptr<CacheReplacement> make_cache_replacement(std::string_view name, std::uint64_t sets, unsigned ways);

}  // namespace grtx::modules
