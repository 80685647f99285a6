// SPDX-License-Identifier: Apache-2.0
// Position of an encoder in a group, for its error messages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>

namespace grtx::traces {

struct GroupPlace {
  static constexpr std::size_t kNowhere = ~std::size_t{0};
  std::uint32_t group = 0;
  std::size_t lane = kNowhere;
  std::size_t round = kNowhere;
  std::size_t event = kNowhere;

  /// Throws std::logic_error.
  [[noreturn, gnu::cold, gnu::noinline]] void fail(const std::string& rule) const {
    std::string place = "trace group " + std::to_string(group);
    if (lane != kNowhere) place += " lane " + std::to_string(lane);
    if (round != kNowhere) place += " round " + std::to_string(round);
    if (event != kNowhere) place += " event " + std::to_string(event);
    throw std::logic_error(place + ": " + rule);
  }
  void require(bool holds, const char* rule) const {
    if (!holds) [[unlikely]]
      fail(rule);
  }
};

}  // namespace grtx::traces
