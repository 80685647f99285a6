// SPDX-License-Identifier: Apache-2.0
// Value change dump (IEEE 1364-2005, clause 18): writes only what changed. Knows nothing of the model. Changes become
// text on a thread of their own, so that the simulation waits for neither the formatting nor the disk.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "grtx/base/atomic_file.h"
#include "grtx/rtl_tlm/observe/block_writer.h"

namespace grtx::sim {

/// Names of the values 0, 1, ... of a signal.
struct Enumeration {
  std::string name;                  ///< of the enumeration, e.g. warp_state
  std::vector<std::string> values;   ///< without spaces
  std::vector<std::string> colours;  ///< X11 names for viewers, by value; may be empty
};

/// Description of a signal for viewers.
struct SignalInfo {
  std::string name;                          ///< full hierarchical name, dots between scopes
  unsigned width = 1;                        ///< bits, 1..64
  const Enumeration* enumeration = nullptr;  ///< null for plain numbers; must outlive the writer
};

/// Declare all signals, then begin(), then alternate advance() and set(), then finish(). Times never go back.
class VcdWriter {
 public:
  using Signal = std::size_t;

  explicit VcdWriter(const std::string& path) : file_(path) {}

  /// An enumeration becomes an attribute table that viewers may show.
  Signal declare(const std::string& name, unsigned width, const Enumeration* enumeration = nullptr);
  /// In order of declaration.
  const std::vector<SignalInfo>& signals() const { return signals_; }

  /// Writes the header. comment: lines of text. Time unit: 1 fs. start_fs: time of the initial values, which are those
  /// given by set() before this call (else 0).
  void begin(const std::string& comment, std::uint64_t start_fs);
  bool begun() const { return begun_; }
  /// Time of the following set() calls. Nothing is written unless a value changes.
  void advance(std::uint64_t time_fs) { time_ = time_fs; }
  /// Throws Error when an earlier change could not be written.
  void set(Signal signal, std::uint64_t value) {
    if (values_[signal] != value) change(signal, value);
  }
  std::uint64_t value(Signal signal) const { return values_[signal]; }
  std::uint64_t changes() const { return changes_; }  ///< written, initial values not counted
  /// Writes the end time and gives the file its final name.
  void finish(std::uint64_t end_fs);

 private:
  /// A new value of a signal, or, with kTime for a signal, a new time.
  struct Record {
    std::uint64_t value = 0;
    Signal signal = 0;
  };
  static constexpr Signal kTime = ~Signal{0};

  void change(Signal signal, std::uint64_t value);
  void append_value(std::string& text, Signal signal, std::uint64_t value) const;
  void append_scopes(std::string& text) const;
  void write_block(const std::vector<Record>& block);

  AtomicFile file_;
  std::vector<SignalInfo> signals_;
  std::vector<std::string> ids_;  ///< by signal: short identifier; constant once begun, as the writer thread reads them
  std::vector<std::uint64_t> values_;
  std::uint64_t time_ = 0;
  std::uint64_t written_time_ = 0;
  std::uint64_t changes_ = 0;
  bool begun_ = false;
  std::string text_;                              ///< of the writer thread
  std::unique_ptr<BlockWriter<Record>> changed_;  ///< last member: its thread ends before the others go
};

}  // namespace grtx::sim
