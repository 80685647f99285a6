// Every file that a command reads and writes: what its options name, and what follows from that. No output may be an
// input or another output.
#pragma once

#include <sys/types.h>

#include <CLI/CLI.hpp>
#include <string>
#include <utility>
#include <vector>

#include "grtx/base/files_read.h"

namespace grtx::sim {

/// Type names of options that name files. --help shows them.
inline constexpr const char* kInputFile = "INPUT";
inline constexpr const char* kOutputFile = "OUTPUT";

class CommandFiles {
 public:
  /// Takes the files of an accepted command line, before anything is done. Throws Error, which names both options.
  void take(const CLI::App& command);
  /// Files that were opened though no option names them. Throws Error when one of them would be written.
  void check(const FilesRead& read) const;
  void check(const std::string& read) const;

 private:
  struct File {
    std::string option, text;      ///< as given
    std::string path;              ///< of this file, without symbolic links
    std::pair<dev_t, ino_t> node;  ///< {0, 0}: there is no such file, or it is no regular one
    bool output = false;
    bool follows = false;  ///< the option names another file, and this one is written with it
  };
  void add(const CLI::Option& option, const std::string& text, const std::string& path, bool output, bool follows);
  static File file_of(const std::string& path);
  static bool same(const File& a, const File& b);
  static std::string what(const File& file);

  std::vector<File> files_;
};

}  // namespace grtx::sim
