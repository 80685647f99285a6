// Value change dump (IEEE 1364-2005, clause 18): writes only what changed. Knows nothing of the model.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/atomic_file.h"

namespace grtx::tlm {

/// Declare all signals, then begin(), then alternate advance() and set(), then finish(). Times never go back.
class VcdWriter {
 public:
  using Signal = std::size_t;

  explicit VcdWriter(const std::string& path) : file_(path) {}

  /// name: full hierarchical name, dots between scopes (gpu.sm0.rt.warps). width: bits, 1..64. enumeration: names of
  /// the values 0, 1, ..., kept as an attribute table that viewers may show; empty for plain numbers.
  Signal declare(const std::string& name, unsigned width, const std::vector<std::string>& enumeration = {});
  std::size_t signals() const { return signals_.size(); }

  /// Writes the header. comment: lines of text; time unit is 1 fs. `start_fs`: time of the initial values, which are
  /// those given by set() before this call (else 0).
  void begin(const std::string& comment, std::uint64_t start_fs);
  /// Time of the following set() calls. Nothing is written unless a value changes.
  void advance(std::uint64_t time_fs) { time_ = time_fs; }
  void set(Signal signal, std::uint64_t value) {
    if (signals_[signal].value != value) change(signal, value);
  }
  /// Writes the end time and gives the file its final name.
  void finish(std::uint64_t end_fs);

 private:
  struct Declared {
    std::string name;
    unsigned width = 1;
    std::vector<std::string> enumeration;
    std::string id;
    std::uint64_t value = 0;
  };
  void change(Signal signal, std::uint64_t value);
  void write_value(const Declared& signal);
  void write_scopes();
  void flush();

  AtomicFile file_;
  std::string buffer_;
  std::vector<Declared> signals_;
  std::uint64_t time_ = 0;
  std::uint64_t written_time_ = 0;
  bool begun_ = false;
};

}  // namespace grtx::tlm
