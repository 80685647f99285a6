// SPDX-License-Identifier: Apache-2.0
// Atomic file output: a file appears under its final name only when complete, so a killed run leaves the old or the new
// file.
#pragma once

#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>

namespace grtx {

/// Writes to "path.partial" (long names are shortened). commit() syncs it to disk and renames it to `path`. The partial
/// file is removed if the object is destroyed uncommitted or a signal ends the process (end_by_signal.h); one left by a
/// killed run is taken over. Symbolic links are followed: their target is replaced. Devices, FIFOs and open descriptors
/// (/dev/stdout) are written directly. Throws Error if the folder is missing or not writable, if the disk is full, or
/// if this process is already writing the same file.
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
  /// Flushes and renames to the final name. Call once.
  void commit();

 private:
  [[noreturn]] void fail(const std::string& place) const;

  std::string path_;     ///< as given
  std::string target_;   ///< final path, with symbolic links followed
  std::string partial_;  ///< "" if written directly
  std::FILE* file_ = nullptr;
  std::size_t size_ = 0;
};

/// Throws the Error of writing `path`, before there is anything to write. Devices and FIFOs are not opened.
void check_writable(const std::string& path);

/// Writes a whole file atomically.
void write_file(const std::string& path, std::string_view content);

/// Throws Error if `path` is not a regular file: opening a FIFO without a writer, for example, would block forever.
void check_regular_file(const std::string& path);

/// Reads a whole file. Throws Error if it cannot be opened or read, or is not a regular file.
std::string read_file(const std::string& path);

}  // namespace grtx
