// SPDX-License-Identifier: Apache-2.0
// Writes a trace file. docs/model/trace-format.md describes the bytes.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::traces {

struct EncodedGroup;  // traces/encode/encoded_group.h

/// Streams groups to a file. append() may be called from many threads in any order of index; chunks are written in
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
  /// Blocks while `group` is more than 1024 groups ahead of the first missing one. Throws std::logic_error, naming
  /// group, lane, round and event, if the events are inconsistent, and Error if the file cannot be written.
  void append(const RayGroup& group);
  /// Stores a group that GroupEncoder encoded with the same header.
  void append(EncodedGroup&& group);
  /// Makes callers that wait in append() throw Error. Call it if a group will not be appended after all.
  void cancel();
  /// Writes the index and totals and gives the file its final name. All groups must have been appended.
  void finish();
  const Header& header() const;
  const Totals& totals() const;
  std::uint64_t bytes() const;
  /// Bytes in memory of the whole decoded trace, and of its largest group.
  std::uint64_t decoded_bytes() const;
  std::uint64_t largest_group() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace grtx::traces
