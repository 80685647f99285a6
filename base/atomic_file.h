// Output files appear under their final name only when complete: a killed run leaves the old file or the new one.
#pragma once

#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>

namespace grtx {

/// Writes to "path.partial.PID" and renames to `path` on commit(); removes the partial file when destroyed uncommitted.
/// Throws Error when the folder is missing or not writable, or the disk is full.
class AtomicFile {
 public:
  explicit AtomicFile(std::string path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(const void* bytes, std::size_t count);
  void write(std::string_view text) { write(text.data(), text.size()); }
  /// Bytes written so far.
  std::size_t size() const { return size_; }
  const std::string& path() const { return path_; }
  /// Flushes, renames to the final name. Call once.
  void commit();

 private:
  std::string path_;
  std::string partial_;
  std::FILE* file_ = nullptr;
  std::size_t size_ = 0;
};

/// Writes a whole file atomically.
void write_file(const std::string& path, std::string_view content);

/// Reads a whole file. Throws Error when it cannot be opened or read.
std::string read_file(const std::string& path);

}  // namespace grtx
