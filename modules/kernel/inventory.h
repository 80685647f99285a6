// SPDX-License-Identifier: Apache-2.0
// Storage bits and operators of a module, derived from the parameters that it simulates with. The cost model
// (explore/cost) reads only these.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace grtx::modules {

enum class StorageKind : std::uint8_t {
  flip_flop,
  ram,
  cache,      ///< data array of a cache; cost models of such arrays include their tags
  cache_tags  ///< those tags, listed only for their number of bits
};

struct Storage {
  std::string name;
  StorageKind kind = StorageKind::flip_flop;
  std::uint64_t bits = 0;
  unsigned read_ports = 1;
  unsigned write_ports = 1;    ///< 0: the read port also writes
  bool added_by_grtx = false;  ///< part of the paper's hardware-cost table
  unsigned word_bits = 32;     ///< bits per access
  unsigned banks = 1;          ///< the bits are split evenly; each bank has its own ports
};

struct Operators {
  std::string name;     ///< a name of explore/cost/operator_cost.cpp: fp_add, fp_mul, int_add, match, ...
  unsigned width = 32;  ///< bits
  std::uint64_t count = 0;
};

struct Inventory {
  std::string module;  ///< hierarchical name
  std::vector<Storage> storage;
  std::vector<Operators> operators;
};

}  // namespace grtx::modules
