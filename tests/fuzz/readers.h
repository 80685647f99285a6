// SPDX-License-Identifier: Apache-2.0
// Every reader of the project as a function of bytes, for libFuzzer, for seeded mutations and for what fuzzers left.
#pragma once

#include <string>
#include <vector>

namespace grtx::fuzzing {

/// Reads files named `file` (its extension says what it is; their folder holds what belongs to it).
struct InputReader {
  std::string name;
  std::string file;
  void (*read)(const std::string& path);
  /// Makes hashes in the bytes fit, so that damage gets past them; nullptr: there are none.
  void (*repair)(std::string& bytes) = nullptr;
  /// Bytes of files that are sound, to begin with.
  std::vector<std::string> (*seeds)() = nullptr;
};

/// Scenes, cameras, object lists, images, traces.
const std::vector<InputReader>& frontend_readers();
/// Configurations, plans, regressions, statistics, results of tasks, databases to fill.
const std::vector<InputReader>& explore_readers();
/// What reports are made of.
const std::vector<InputReader>& report_readers();

/// A folder in memory, of this process.
const std::string& folder();

/// Reads `bytes`: it is read, or refused with an Error that has a rule; any other exception leaves. Returns whether it
/// was read.
bool read_bytes(const InputReader& reader, std::string bytes);

/// What libFuzzer kept as one input for each way that it found through a reader: tests/fuzz/corpus/NAME.tar.zst, packed
/// by scripts/fuzz_corpus.py.
std::vector<std::string> corpus(const InputReader& reader);

}  // namespace grtx::fuzzing
