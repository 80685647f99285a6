// SPDX-License-Identifier: Apache-2.0
// All files that a command reads and writes: those named by its options, and those derived from them. Checks that no
// output is also an input or another output.
#pragma once

#include <sys/types.h>

#include <CLI/CLI.hpp>
#include <string>
#include <utility>
#include <vector>

#include "grtx/base/files_read.h"

namespace grtx::apps {

/// Type names of options that name files. --help shows them. A machine is a name, a file, or "": all keys at their
/// defaults.
inline constexpr const char* kMachineType = "MACHINE";
inline constexpr const char* kInputFile = "INPUT";
inline constexpr const char* kOutputFile = "OUTPUT";

class CommandFiles {
 public:
  /// Collects the files of a parsed command line; call before the command runs. Throws Error naming both options if an
  /// output would overwrite another file of the command, or if an output cannot be written.
  void take(const CLI::App& command);
  /// Checks input files that no option names directly. Throws Error if the command would overwrite one.
  void check(const FilesRead& read) const;
  void check(const std::string& read) const;

 private:
  struct File {
    std::string option, text;      ///< as given
    std::string path;              ///< of this file, symbolic links resolved
    std::pair<dev_t, ino_t> node;  ///< {0, 0}: no such file, or not a regular one
    bool output = false;
    bool follows = false;  ///< derived: written along with the file that the option names
  };
  void add(const CLI::Option& option, const std::string& text, const std::string& path, bool output, bool follows);
  static File file_of(const std::string& path);
  static bool same(const File& a, const File& b);
  static std::string what(const File& file);

  std::vector<File> files_;
};

}  // namespace grtx::apps
