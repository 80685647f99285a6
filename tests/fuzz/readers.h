// Every reader of the project as a function of bytes, for libFuzzer and for the finds that are kept.
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

const std::vector<InputReader>& input_readers();

/// Reads `bytes`: it is read, or refused with an Error that has a rule; any other exception leaves. Returns whether it
/// was read.
bool read_bytes(const InputReader& reader, std::string bytes);

}  // namespace grtx::fuzzing
