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

namespace grtx::e2e {

struct Outcome {
  int code = -1;  ///< exit code; -1 when it ended by a signal
  std::string out;
  std::string err;
};

/// A folder of its own for each test, removed at its end.
class Folder {
 public:
  Folder() {
    static int count = 0;
    path_ = std::filesystem::path(::testing::TempDir()) /
            ("grtx_e2e_" + std::to_string(::getpid()) + "_" + std::to_string(++count));
    std::filesystem::create_directories(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string path(const std::string& name) const { return (path_ / name).string(); }
  std::string write(const std::string& name, const std::string& content) const {
    std::ofstream(path_ / name, std::ios::binary) << content;
    return path(name);
  }
  std::string read(const std::string& name) const {
    std::ifstream file(path_ / name, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  }
  bool has(const std::string& name) const { return std::filesystem::exists(path_ / name); }

  /// Runs the program in this folder. `arguments` go through the shell.
  Outcome run(const std::string& arguments) const {
    const std::string command =
        "cd '" + path_.string() + "' && '" + grtx::paths::program() + "' " + arguments + " >.stdout 2>.stderr";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read(".stdout"), read(".stderr")};
  }

 private:
  std::filesystem::path path_;
};

/// What every error of the program looks like: one line that begins with the program's name.
inline bool is_one_error_line(const std::string& text) {
  return text.starts_with("grtx: ") && text.find('\n') == text.size() - 1;
}

}  // namespace grtx::e2e
