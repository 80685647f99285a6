// SPDX-License-Identifier: Apache-2.0
// Lock file that keeps other processes from writing the same output. Released when the process ends, in whatever way.
#pragma once

#include <string>

namespace grtx {

class FileLock {
 public:
  /// path: the lock file, created empty and removed at the end; a killed process leaves it behind. what: file or folder
  /// that it protects. busy: rule of the Error{what, "", busy} thrown if another process has the lock. Throws Error if
  /// the file is not a lock file or cannot be created.
  FileLock(std::string path, const std::string& what, const std::string& busy);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  std::string path_;
  int file_ = -1;
};

}  // namespace grtx
