// SPDX-License-Identifier: Apache-2.0
// Choice between the SystemC and the RTL implementation of a unit.
#pragma once

#include <array>
#include <cstdint>

#include "grtx/base/declare/named_enum.h"

namespace grtx::modules {

/// The SystemC unit, or a Verilated block behind the same interface (rtl_tlm/rtl).
enum class UnitImplementation : std::uint8_t { tlm, rtl };
constexpr auto enum_names(UnitImplementation) { return names_in_order<UnitImplementation>({"tlm", "rtl"}); }

inline constexpr const char* kUnitImplementations =
    "the SystemC unit, or its SystemVerilog by Verilator, with the same statistics (rtl_bridge.md)";

}  // namespace grtx::modules
