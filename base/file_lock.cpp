// SPDX-License-Identifier: Apache-2.0
#include "grtx/base/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "grtx/base/error.h"

namespace grtx {

FileLock::FileLock(std::string path, const std::string& what, const std::string& busy) : path_(std::move(path)) {
  for (;;) {
    file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0644);
    if (file_ < 0) throw Error(what, "", std::string("cannot be locked: ") + std::strerror(errno));
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
      const int why = errno;
      ::close(file_);
      throw Error(what, "", why == EWOULDBLOCK ? busy : std::string("cannot be locked: ") + std::strerror(why));
    }
    // The previous holder may have removed the file after it was opened here.
    struct stat opened {
    }, named{};
    const bool same =
        ::fstat(file_, &opened) == 0 && ::stat(path_.c_str(), &named) == 0 && opened.st_ino == named.st_ino;
    if (same && S_ISREG(opened.st_mode) && opened.st_size == 0) return;
    ::close(file_);
    if (same) throw Error(path_, "", "is no lock (which is empty, and deleted at the end): move it away");
  }
}

FileLock::~FileLock() {
  ::unlink(path_.c_str());
  ::close(file_);
}

}  // namespace grtx
