// SPDX-License-Identifier: Apache-2.0
#include "grtx/base/atomic_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>

#include "grtx/base/end_by_signal.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"

namespace grtx {
namespace {

namespace fs = std::filesystem;

int open_partial(const std::string& target, std::string& name);

/// The files that this process is writing.
class Targets {
 public:
  static Targets& all() {
    static Targets targets;
    return targets;
  }
  bool add(const std::string& target) {
    const std::lock_guard lock(mutex_);
    return partial_files_.try_emplace(target).second;
  }
  /// open_partial() of an added target; from the moment the file exists, a signal removes it.
  int open(const std::string& target, std::string& name) {
    const std::lock_guard lock(mutex_);
    const DelayedSignals delayed;
    const int file = open_partial(target, name);
    if (file >= 0) partial_files_.at(target).emplace(name, delayed);
    return file;
  }
  void remove(const std::string& target) {
    const std::lock_guard lock(mutex_);
    partial_files_.erase(target);
  }

 private:
  std::mutex mutex_;
  std::map<std::string, std::optional<RemovedBySignal>> partial_files_;  ///< target -> partial file
};

/// Whether a path leads to an open descriptor, like /dev/stdout and /dev/fd/3.
bool is_descriptor(const fs::path& path) {
  std::error_code none;
  const fs::path descriptors = fs::canonical("/proc/self/fd", none);
  return !none && fs::canonical(path.parent_path(), none) == descriptors;
}

/// Follows symbolic links in the last component of a path, whether or not the target exists.
std::string followed(const std::string& path) {
  constexpr int kMostLinks = 40;  // as in Linux
  fs::path at = path;
  std::error_code none;
  for (int i = 0; i < kMostLinks && fs::is_symlink(fs::symlink_status(at, none)) && !is_descriptor(at); ++i) {
    const fs::path link = fs::read_symlink(at, none);
    if (none) break;
    at = link.is_absolute() ? link : at.parent_path() / link;
  }
  return at.string();
}

/// target + ending; if that is too long for the file system, the end of the name is replaced by a hash.
std::string beside(const fs::path& target, const std::string& ending) {
  const std::string name = target.filename().string();
  const fs::path folder = target.parent_path();
  const long told = ::pathconf(folder.empty() ? "." : folder.c_str(), _PC_NAME_MAX);
  const std::size_t most = told > 0 ? static_cast<std::size_t>(told) : NAME_MAX;
  if (name.size() + ending.size() <= most) return target.string() + ending;
  const std::string end = "-" + hex(xxh3(name)) + ending;
  std::size_t kept = most - std::min(most, end.size());
  while (kept > 0 && (static_cast<unsigned char>(name[kept]) & 0xc0U) == 0x80U) --kept;  // keep whole UTF-8 characters
  return (folder / (name.substr(0, kept) + end)).string();
}

/// Opens and locks "target.partial", possibly one left by a killed run. If another process is writing it, locks are not
/// supported, or that name is a link or no file at all, the file is a new one whose name contains this process's
/// number. Returns the descriptor, or -1 with errno.
int open_partial(const std::string& target, std::string& name) {
  name = beside(target, ".partial");
  for (;;) {
    const int file = ::open(name.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
    if (file < 0 && errno != ELOOP && errno != ENXIO) return -1;
    struct stat opened {
    }, named{};
    // A file with a second name is somebody else's, too.
    const bool locked = file >= 0 && ::fstat(file, &opened) == 0 && S_ISREG(opened.st_mode) && opened.st_nlink <= 1 &&
                        ::flock(file, LOCK_EX | LOCK_NB) == 0;
    if (!locked) {
      if (file >= 0) ::close(file);
      break;
    }
    // Its writer may have renamed it to its final name after it was opened here.
    if (::lstat(name.c_str(), &named) == 0 && named.st_ino == opened.st_ino && ::ftruncate(file, 0) == 0) return file;
    ::close(file);
  }
  const std::string own = ".partial." + std::to_string(::getpid());
  for (unsigned i = 0;; ++i) {
    name = beside(target, i == 0 ? own : own + "." + std::to_string(i));
    // O_EXCL: a new file, never through a link.
    const int file = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file >= 0 || errno != EEXIST) return file;
  }
}

/// Syncs the folder, so that a rename is also on disk. Errors are ignored, since not every file system supports it.
void sync_folder_of(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  const int file = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) return;
  ::fsync(file);
  ::close(file);
}

}  // namespace

void AtomicFile::fail(const std::string& place) const {
  throw Error(path_, place, std::string("cannot be written: ") + std::strerror(errno));
}

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)), target_(followed(path_)) {
  struct stat status {};
  const bool exists = ::stat(target_.c_str(), &status) == 0;
  if (!exists && errno != ENOENT) fail("");
  if (exists && S_ISDIR(status.st_mode)) throw Error(path_, "", "cannot be written: is a folder");
  if (!Targets::all().add(target_)) throw Error(path_, "", "is written already: two outputs have one name");
  int descriptor = -1;
  if (is_descriptor(target_)) {
    std::fflush(stdout);  // so that earlier output precedes this file
    descriptor = ::fcntl(std::atoi(fs::path(target_).filename().c_str()), F_DUPFD_CLOEXEC, 3);
  } else if (exists && !S_ISREG(status.st_mode)) {
    descriptor = ::open(target_.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY);
  } else {
    descriptor = Targets::all().open(target_, partial_);
  }
  if (descriptor >= 0) file_ = ::fdopen(descriptor, "wb");
  if (file_ != nullptr) return;
  const int why = errno;
  if (descriptor >= 0) ::close(descriptor);
  Targets::all().remove(target_);
  errno = why;
  fail("");
}

AtomicFile::~AtomicFile() {
  if (file_ == nullptr) return;
  if (!partial_.empty()) std::remove(partial_.c_str());  // while locked, so that it is still our file
  std::fclose(file_);
  Targets::all().remove(target_);
}

void AtomicFile::write(const void* bytes, std::size_t count) {
  if (count == 0) return;
  if (std::fwrite(bytes, 1, count, file_) != count) fail("byte " + std::to_string(size_));
  size_ += count;
}

void AtomicFile::commit() {
  const bool regular = !partial_.empty();
  bool done = std::fflush(file_) == 0 && (!regular || ::fsync(::fileno(file_)) == 0);
  int why = errno;
  const auto then = [&](bool succeeded) {
    if (done && !succeeded) why = errno;
    done = done && succeeded;
  };
  // Rename while locked: otherwise another process could take over the partial file, and its file would be renamed.
  if (done && regular) then(std::rename(partial_.c_str(), target_.c_str()) == 0);
  if (!done && regular) std::remove(partial_.c_str());
  const bool closed = std::fclose(file_) == 0;
  if (!regular) then(closed);  // a regular file is already synced
  file_ = nullptr;
  Targets::all().remove(target_);
  errno = why;
  if (!done) fail("");
  if (regular) sync_folder_of(target_);
}

void check_writable(const std::string& path) {
  struct stat status {};
  const bool exists = ::stat(path.c_str(), &status) == 0;
  if (!exists || S_ISREG(status.st_mode) || S_ISDIR(status.st_mode)) const AtomicFile probe(path);
}

void write_file(const std::string& path, std::string_view content) {
  AtomicFile file(path);
  file.write(content);
  file.commit();
}

namespace {

struct stat regular_file(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) throw Error(path, "", std::strerror(errno));
  if (!S_ISREG(status.st_mode)) throw Error(path, "", "is not a regular file");
  return status;
}

}  // namespace

void check_regular_file(const std::string& path) { regular_file(path); }

std::string read_file(const std::string& path) {
  const struct stat status = regular_file(path);
  std::FILE* file = std::fopen(path.c_str(), "rb");
  if (file == nullptr) throw Error(path, "", std::string("cannot be read: ") + std::strerror(errno));
  std::string content(static_cast<std::size_t>(status.st_size), '\0');
  const std::size_t got = std::fread(content.data(), 1, content.size(), file);
  std::fclose(file);
  if (got != content.size()) throw Error(path, "byte " + std::to_string(got), "cannot be read to its end");
  return content;
}

}  // namespace grtx
