// SPDX-License-Identifier: Apache-2.0
// List of the input files of a result, each with the hash of the bytes read. Readers pass it on and add to it.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace grtx {

class FilesRead {
 public:
  struct File {
    std::string path;  ///< as opened
    std::string name;  ///< name given by the reader, independent of the folder of the inputs
    std::uint64_t hash = 0;
  };

  /// read_file(), and adds the file. name: "" for the file name without its folder.
  std::string read(const std::string& path, const std::string& name = "");
  /// Adds a file of which only `bytes` were read.
  void note(const std::string& path, std::string_view bytes, const std::string& name = "");

  /// Appends the files of another reader.
  void add(const FilesRead& later) { files_.insert(files_.end(), later.files_.begin(), later.files_.end()); }

  /// In reading order.
  const std::vector<File>& files() const { return files_; }
  /// Hash of the contents of all files, in hexadecimal; independent of their names and folders.
  std::string hash() const;
  /// For the inputs of results: "files", each with its hash, and "files_hash".
  std::map<std::string, std::string> inputs() const;

 private:
  std::vector<File> files_;
};

/// Key of hash() in inputs().
inline constexpr const char* kFilesHash = "files_hash";

}  // namespace grtx
