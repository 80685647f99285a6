// SPDX-License-Identifier: Apache-2.0
// Base classes of the parts of an RT unit, with the functions that its netlist requires of each, user-supplied or not.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <systemc>

#include "grtx/base/strong.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"

namespace grtx::modules {

/// Whether a part is awake. An RT unit reads that of all its parts in each cycle, so their bits are in one word of it.
class AwakeBit {
 public:
  AwakeBit() = default;
  AwakeBit(const AwakeBit&) = delete;
  AwakeBit& operator=(const AwakeBit&) = delete;
  operator bool() const { return (*word_ & bit_) != 0; }
  AwakeBit& operator=(bool awake) {
    *word_ = awake ? *word_ | bit_ : *word_ & ~bit_;
    return *this;
  }
  /// From now on it is in `word`, which must live as long.
  void move_to(std::uint32_t& word, unsigned bit) {
    const bool awake = *this;
    word_ = &word;
    bit_ = std::uint32_t{1} << bit;
    *this = awake;
  }

 private:
  std::uint32_t own_ = 1;
  std::uint32_t* word_ = &own_;
  std::uint32_t bit_ = 1;
};

/// The netlist calls the stages of a part in the order of RtUnit::run_stages(). Parts reach their neighbours through
/// ports.
class RtPart : public sc_core::sc_module {
 public:
  /// Whether nothing is inside: no request and no pending response. Does not consider the links.
  virtual bool idle() const = 0;
  /// Grows whenever the part makes progress; for a watchdog.
  virtual std::uint64_t progress() const = 0;
  /// Adds counters of a user-defined part that the project's parts do not have; the common ones are returned by
  /// counters() of its interface.
  virtual void count(OwnCounts& /*own*/) const {}
  virtual Inventory inventory() const = 0;
  virtual void dump_state(std::ostream& out) const = 0;
  /// Prepares for another launch, and drops the part's contents (Clocked::restart()).
  virtual void restart() {}
  /// False while the stages of the part would do nothing if nothing arrived on its links: they are then not called.
  bool awake() const { return awake_; }
  /// The netlist: awake() is to be this bit.
  void show_awake(std::uint32_t& word, unsigned bit) { awake_.move_to(word, bit); }

 protected:
  explicit RtPart(const sc_core::sc_module_name& name) : sc_module(name) {}
  explicit RtPart(const char* name) = delete;  ///< members would land in the module around it: see ClockedModule

  AwakeBit awake_;  ///< a derived part may keep it up to date, which saves calls; true is always right
};

/// A part that is a client of the L1.
class RtMemoryPart : public RtPart {
 public:
  /// Receives at most one response.
  virtual void respond(Cycle now) = 0;
  /// Sends at most one request.
  virtual void issue(Cycle now) = 0;
  /// Whether there is work in the next cycle even if nothing arrives.
  virtual bool busy() const = 0;

 protected:
  using RtPart::RtPart;
};

}  // namespace grtx::modules
