// SPDX-License-Identifier: Apache-2.0
// sram_cacti7.csv, compiled in: CACTI 7.0 (HewlettPackard/cacti) at 350 K, without ECC, one bank; caches read tags
// first. Columns as in its header row: energies are per access of a word (ram) or of the bus (cache); 16-way caches of
// 128 B lines, tags included.
#pragma once

#include <string_view>

namespace grtx::explore {

extern const std::string_view kSramTable;

}  // namespace grtx::explore
