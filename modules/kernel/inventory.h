// What a module is made of: storage bits and operators, stated from the parameters it simulates with. The cost model
// only walks these.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace grtx::modules {

enum class StorageKind : std::uint8_t {
  flip_flop,
  ram,
  cache,      ///< data array of a cache; cost models of such arrays include their tags
  cache_tags  ///< those tags, stated for their bits
};

struct Storage {
  std::string name;
  StorageKind kind = StorageKind::flip_flop;
  std::uint64_t bits = 0;
  unsigned read_ports = 1;
  unsigned write_ports = 1;    ///< 0: the read port writes, too
  bool added_by_grtx = false;  ///< part of the paper's hardware-cost table
  unsigned word_bits = 32;     ///< of one access
  unsigned banks = 1;          ///< that the bits are divided among, each with ports of its own
};

struct Operators {
  std::string name;     ///< a name of lab/cost/operator_cost.cpp: fp_add, fp_mul, int_add, match, ...
  unsigned width = 32;  ///< bits
  std::uint64_t count = 0;
};

struct Inventory {
  std::string module;  ///< hierarchical name
  std::vector<Storage> storage;
  std::vector<Operators> operators;
};

}  // namespace grtx::modules
