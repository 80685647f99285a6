// Keeps a second process off what this one fills. The lock ends with the process, however that ends.
#pragma once

#include <string>

namespace grtx {

class FileLock {
 public:
  /// path: of the lock's own file, empty, made here and removed at the end; a killed process leaves it. what: file or
  /// folder that it stands for. busy: what is said of it when another process has the lock, thrown as
  /// Error{what, "", busy}. Throws Error for a file that is no lock, or cannot be made.
  FileLock(std::string path, const std::string& what, const std::string& busy);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  std::string path_;
  int file_ = -1;
};

}  // namespace grtx
