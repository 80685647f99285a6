// What a reader opened: every file with the hash of the bytes that were taken from it. It is handed from reader to
// reader, and says in the end what a result was made from.
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
    std::string path;  ///< as it was opened
    std::string name;  ///< as whoever opened it calls it: says nothing about the folder that all lie in
    std::uint64_t hash = 0;
  };

  /// read_file(), and notes it. name: "" for that of the file alone.
  std::string read(const std::string& path, const std::string& name = "");
  /// A file of which these bytes alone were taken.
  void note(const std::string& path, std::string_view bytes, const std::string& name = "");

  /// What another reader opened, after what is here.
  void add(const FilesRead& later) { files_.insert(files_.end(), later.files_.begin(), later.files_.end()); }

  /// In the order of reading.
  const std::vector<File>& files() const { return files_; }
  /// Hash of what all files said, hexadecimal. What they are called and where they lie is no part of it.
  std::string hash() const;
  /// For the inputs of results: "files", each with its hash, and "files_hash".
  std::map<std::string, std::string> inputs() const;

 private:
  std::vector<File> files_;
};

/// The name of hash() among inputs().
inline constexpr const char* kFilesHash = "files_hash";

}  // namespace grtx
