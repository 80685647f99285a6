// Output files appear under their final name only when complete: a killed run leaves the old file or the new one.
#pragma once

#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>

namespace grtx {

/// Writes to "path.partial" (or a like name: long ones are cut) and renames to `path` on commit(), when all of it is on
/// the disk. Removes the partial file when destroyed uncommitted or ended by a signal (end_by_signal.h); takes over
/// what a killed run has left. A symbolic link is followed: its target is replaced. A device, a FIFO and what is open
/// already
/// (/dev/stdout) are written directly. Throws Error when the folder is missing or not writable, when the disk is full,
/// and when this process is writing the same file already.
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
  [[noreturn]] void fail(const std::string& place) const;

  std::string path_;     ///< as given
  std::string target_;   ///< where it ends up
  std::string partial_;  ///< "": written directly
  std::FILE* file_ = nullptr;
  std::size_t size_ = 0;
};

/// Writes a whole file atomically.
void write_file(const std::string& path, std::string_view content);

/// Inputs are regular files: a FIFO without a writer would be waited for without end. Throws Error when `path` is none.
void check_regular_file(const std::string& path);

/// Reads a whole file. Throws Error when it cannot be opened or read, or is no regular file.
std::string read_file(const std::string& path);

}  // namespace grtx
