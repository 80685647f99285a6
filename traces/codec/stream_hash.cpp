// SPDX-License-Identifier: Apache-2.0
#include "grtx/traces/codec/stream_hash.h"

#include <xxhash.h>

#include <new>

namespace grtx::traces {

struct StreamHash::State {
  State() : xxh(XXH3_createState()) {
    if (xxh == nullptr) throw std::bad_alloc();
    XXH3_64bits_reset(xxh);
  }
  ~State() { XXH3_freeState(xxh); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  XXH3_state_t* xxh;
};

StreamHash::StreamHash() : state_(std::make_unique<State>()) {}
StreamHash::~StreamHash() = default;
void StreamHash::add(const void* bytes, std::size_t count) { XXH3_64bits_update(state_->xxh, bytes, count); }
std::uint64_t StreamHash::value() const { return XXH3_64bits_digest(state_->xxh); }

}  // namespace grtx::traces
