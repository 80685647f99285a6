// SPDX-License-Identifier: Apache-2.0
// Incremental XXH3 hash.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

namespace grtx::traces {

class StreamHash {
 public:
  StreamHash();
  ~StreamHash();
  StreamHash(const StreamHash&) = delete;
  StreamHash& operator=(const StreamHash&) = delete;

  void add(const void* bytes, std::size_t count);
  /// Hash of all bytes added so far.
  std::uint64_t value() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace grtx::traces
