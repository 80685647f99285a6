// SPDX-License-Identifier: Apache-2.0
#include "grtx/base/hash.h"

#include <fmt/format.h>
#include <xxhash.h>

namespace grtx {

std::uint64_t xxh3(const void* bytes, std::size_t count) { return XXH3_64bits(bytes, count); }

std::string hex(std::uint64_t value) { return fmt::format("{:016x}", value); }

}  // namespace grtx
