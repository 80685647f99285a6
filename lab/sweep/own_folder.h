// A folder whose content is deleted: only where a file in it says that it was made for that.
#pragma once

#include <string>

namespace grtx::sim {

/// Whatever lies in it is lost with it, so it holds a mark, `.grtx-work`. What has no mark is somebody else's.
class OwnFolder {
 public:
  /// Throws Error when `path` is something that was not made here: a folder without the mark that is not empty, a
  /// symbolic link, no folder at all.
  explicit OwnFolder(std::string path);
  const std::string& path() const { return path_; }
  /// With its mark, and the folders above it. Throws Error when it cannot be made.
  void make() const;
  /// With all that it holds, as far as possible: somebody may still be writing into it.
  void remove() const;

 private:
  std::string path_;
};

}  // namespace grtx::sim
