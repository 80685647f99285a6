// SPDX-License-Identifier: Apache-2.0
// A path of its own for each test, removed at its end.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <string>

#include "grtx/traces/writer.h"

namespace grtx::traces::testing {

class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& name = "trace")
      : path_(::testing::TempDir() + name + "." + std::to_string(::getpid()) + "." + std::to_string(++count()) +
              ".grtx") {}
  ~TemporaryFile() { std::remove(path_.c_str()); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  static int& count() {
    static int value = 0;
    return value;
  }
  std::string path_;
};

inline void write_trace(const std::string& path, const Header& header, const std::vector<RayGroup>& groups) {
  Writer writer(path, header);
  for (const RayGroup& group : groups) writer.append(group);
  writer.finish();
}

/// One that holds a trace.
class TraceFile : public TemporaryFile {
 public:
  TraceFile(const Header& header, const std::vector<RayGroup>& groups) { write_trace(path(), header, groups); }
};

}  // namespace grtx::traces::testing
