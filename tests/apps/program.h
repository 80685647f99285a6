// SPDX-License-Identifier: Apache-2.0
// Runs the built `grtx` program and looks at what it prints and how it ends.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "paths.h"
#include "temporary_folder.h"

namespace grtx::e2e {

struct Outcome {
  int code = -1;  ///< exit code; -1 when it ended by a signal
  std::string out;
  std::string err;
};

class Folder : public grtx::test::TemporaryFolder {
 public:
  /// Runs the program in this folder. `arguments` go through the shell, as does `before`, a program that runs it.
  Outcome run(const std::string& arguments, const std::string& before = "") const {
    const std::string command =
        "cd '" + path() + "' && " + before + " '" + grtx::paths::program() + "' " + arguments + " >.stdout 2>.stderr";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read(".stdout"), read(".stderr")};
  }
};

/// What every error of the program looks like: one line that begins with the program's name.
inline bool is_one_error_line(const std::string& text) {
  return text.starts_with("grtx: ") && text.find('\n') == text.size() - 1;
}

}  // namespace grtx::e2e
