// Writes a trace file. docs/model/trace-format.md describes the bytes.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::traces {

struct EncodedGroup;  // traces/codec/encoded_group.h

/// Streams groups to a file. append() may be called from many threads in any order of index; chunks land in the file in
/// index order, so the file is byte-identical for any number of threads. Memory is bounded by the groups in flight.
class Writer {
 public:
  /// Creates `path` (under a temporary name until finish()). header.groups groups must be appended, indices
  /// 0..groups-1.
  Writer(const std::string& path, const Header& header);
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  /// Encodes and stores one group. Thread-safe. Encoding runs in the caller's thread.
  /// Blocks while `group` is more than 1024 groups ahead of the first one missing. Throws std::logic_error, naming
  /// group, lane, round and event, when the events contradict each other, and Error when the file cannot be written.
  void append(const RayGroup& group);
  /// Stores a group that GroupEncoder has encoded with the same header.
  void append(EncodedGroup&& group);
  /// Wakes callers that wait in append(), with an Error. For a thread that will not append its group after all.
  void cancel();
  /// Writes the index and totals, gives the file its final name. All groups must have been appended.
  void finish();
  const Header& header() const;
  const Totals& totals() const;
  std::uint64_t bytes() const;
  /// What a reader of the whole trace holds when it has decoded it, and of that the largest group; bytes.
  std::uint64_t decoded_bytes() const;
  std::uint64_t largest_group() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace grtx::traces
