// SPDX-License-Identifier: Apache-2.0
// Reads a trace file. docs/model/trace-format.md describes the bytes.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::traces {

/// Random access to the groups of a file. Holds only the requested group in memory. read() is thread-safe.
/// Throws Error{path, offset, rule} on any violation of the format, including a wrong hash or version.
class Reader {
 public:
  explicit Reader(const std::string& path);
  ~Reader();
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  const Header& header() const;
  const Totals& totals() const;
  const std::string& path() const;
  std::uint64_t bytes() const;
  /// XXH3 of the file content except the footer's own hash, in hexadecimal; identifies the trace in results.
  const std::string& content_hash() const;
  std::uint64_t group_count() const;
  /// Decodes group `index` into `group`, reusing its memory.
  void read(std::uint64_t index, RayGroup& group) const;
  /// Reads the whole file and throws Error if its hash is not content_hash().
  void verify_content() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace grtx::traces
