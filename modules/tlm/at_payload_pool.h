// SPDX-License-Identifier: Apache-2.0
// Memory manager and payload pool for TLM-2.0 AT transactions: a free list, no allocation in the steady state.
#pragma once

#include <array>
#include <cassert>
#include <cstdint>
#include <memory>
#include <tlm>
#include <vector>

#include "grtx/modules/tlm/origin_extension.h"

namespace grtx::modules {

/// A generic payload with its data buffer and the requester's context. Responses are matched by payload; the address,
/// which interconnects may rewrite, is never read back.
class AtPayload final : public ::tlm::tlm_generic_payload {
 public:
  static constexpr unsigned kMaxBytes = 128;
  explicit AtPayload(::tlm::tlm_mm_interface* memory_manager) : tlm_generic_payload(memory_manager) {
    set_extension(&origin);
  }
  ~AtPayload() override { clear_extension(&origin); }  // a member, which the base class must not free

  std::uint64_t sent_address = 0;
  std::uint32_t context = 0;
  bool responded = false;
  OriginExtension origin;
  std::array<unsigned char, kMaxBytes> data{};
};

/// free() resets the payload, which removes auto-extensions added by targets. A payload still held by a target when the
/// pool is destroyed must not be released afterwards.
class AtPayloadPool final : public ::tlm::tlm_mm_interface {
 public:
  /// Returns a payload with reference count 1 and the default attributes of the base protocol.
  AtPayload& acquire() {
    if (free_.empty()) {
      all_.push_back(std::make_unique<AtPayload>(this));
      free_.push_back(all_.back().get());
    }
    AtPayload& payload = *free_.back();
    free_.pop_back();
    payload.acquire();
    payload.responded = false;
    return payload;
  }
  void free(::tlm::tlm_generic_payload* payload) override {
    payload->reset();
    free_.push_back(static_cast<AtPayload*>(payload));
    assert(free_.size() <= all_.size());
  }
  std::size_t live() const { return all_.size() - free_.size(); }
  std::size_t allocated() const { return all_.size(); }

 private:
  std::vector<std::unique_ptr<AtPayload>> all_;
  std::vector<AtPayload*> free_;
};

}  // namespace grtx::modules
