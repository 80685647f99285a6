// SPDX-License-Identifier: Apache-2.0
// A folder that may be deleted with its content: recognised by a mark file in it.
#pragma once

#include <string>

namespace grtx::explore {

/// remove() deletes everything in the folder, so only folders with the mark file `.grtx-work` are accepted.
class MarkedFolder {
 public:
  /// Throws Error if `path` exists and is not ours: a non-empty folder without the mark, a symbolic link, or no folder.
  explicit MarkedFolder(std::string path);
  const std::string& path() const { return path_; }
  /// Creates the folder with its mark, and missing parents. Throws an exception if that fails.
  void make() const;
  /// Deletes the folder and its content as far as possible; ignores errors, since a process may still write to it.
  void remove() const;

 private:
  std::string path_;
};

}  // namespace grtx::explore
