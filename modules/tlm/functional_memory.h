// SPDX-License-Identifier: Apache-2.0
// Contents of a memory, without timing: pages allocated on first write; bytes never written read as 0.
#pragma once

#include <array>
#include <cstdint>
#include <tlm>
#include <unordered_map>

namespace grtx::modules {

class FunctionalMemory {
 public:
  /// Executes the payload's read or write, honouring byte enables. Returns its length in bytes; 0 without a data
  /// pointer.
  unsigned access(const ::tlm::tlm_generic_payload& payload) {
    const unsigned bytes = payload.get_data_length();
    if (payload.get_data_ptr() == nullptr) return 0;
    unsigned char* const data = payload.get_data_ptr();
    const unsigned char* const enables = payload.get_byte_enable_ptr();
    const unsigned pattern = payload.get_byte_enable_length();
    for (unsigned i = 0; i < bytes; ++i) {
      if (enables != nullptr && pattern != 0 && enables[i % pattern] != TLM_BYTE_ENABLED) continue;
      const std::uint64_t address = payload.get_address() + i;
      if (payload.is_write()) {
        pages_[address / kPage][address % kPage] = data[i];
      } else if (payload.is_read()) {
        const auto page = pages_.find(address / kPage);
        data[i] = page == pages_.end() ? 0 : page->second[address % kPage];
      }
    }
    return bytes;
  }

 private:
  static constexpr std::uint64_t kPage = 4096;
  std::unordered_map<std::uint64_t, std::array<unsigned char, kPage>> pages_;
};

}  // namespace grtx::modules
