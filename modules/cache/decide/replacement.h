// SPDX-License-Identifier: Apache-2.0
// Cache replacement policies: which line of a full set is evicted. Selected by name, free of SystemC. `lru` is built
// into the tag array for speed; the others are in policies/, one file each. Register a policy of your own before the
// first cache is constructed.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "grtx/base/state_bytes.h"
#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

/// Each function is told of the access that it is about: address, kind of data (region), SM, port of its L1 (client),
/// whether it writes or prefetches. For a fill it is the first that waited for the sector. A sector that is put there
/// before a run, by preload(), comes with its address alone.
class CacheReplacement {
 public:
  virtual ~CacheReplacement() = default;
  /// A line was placed into `way`. Empty ways are filled first, lowest first. In a full set `way` differs from victim()
  /// if the victim was dirty and could not be written back; it is then the next clean way, with wrap-around.
  virtual void filled(std::uint64_t set, unsigned way, const MemoryRequest& access) = 0;
  /// The line in `way` was hit.
  virtual void referenced(std::uint64_t set, unsigned way, const MemoryRequest& access) = 0;
  /// The way to evict from a full set for this access, below `ways`; another ends the run. Must return the same way for
  /// the same access until filled() is called for the set, because a cache may ask more than once.
  virtual unsigned victim(std::uint64_t set, const MemoryRequest& access) const = 0;
  /// Hardware state of the policy, in bits per line (for the cost model).
  virtual unsigned bits_per_line() const = 0;
  /// Saves the complete state, for a run that another process continues. Returns false if not supported.
  virtual bool save(StateWriter&) const { return false; }
  virtual void load(StateReader&) {}
};

using CacheReplacementFactory = std::function<std::unique_ptr<CacheReplacement>(std::uint64_t sets, unsigned ways)>;

/// Makes `name` a value of l1.replacement and l2.replacement. Throws std::logic_error if the name is taken.
void register_cache_replacement(const std::string& name, CacheReplacementFactory factory);
/// All registered names, including lru.
std::vector<std::string> cache_replacement_names();
/// Returns nullptr for lru only. Throws Error for an unknown name, with the known ones, and for a factory that makes
/// nothing.
std::unique_ptr<CacheReplacement> make_cache_replacement(std::string_view name, std::uint64_t sets, unsigned ways);

}  // namespace grtx::modules
