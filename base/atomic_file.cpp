#include "grtx/base/atomic_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "grtx/base/error.h"

namespace grtx {

AtomicFile::AtomicFile(std::string path)
    : path_(std::move(path)), partial_(path_ + ".partial." + std::to_string(::getpid())) {
  file_ = std::fopen(partial_.c_str(), "wb");
  if (file_ == nullptr) throw Error(path_, "", std::string("cannot be written: ") + std::strerror(errno));
}

AtomicFile::~AtomicFile() {
  if (file_ != nullptr) {
    std::fclose(file_);
    std::remove(partial_.c_str());
  }
}

void AtomicFile::write(const void* bytes, std::size_t count) {
  if (count == 0) return;
  if (std::fwrite(bytes, 1, count, file_) != count) {
    throw Error(path_, "byte " + std::to_string(size_), std::string("cannot be written: ") + std::strerror(errno));
  }
  size_ += count;
}

void AtomicFile::commit() {
  const bool closed = std::fclose(file_) == 0;
  file_ = nullptr;
  if (!closed || std::rename(partial_.c_str(), path_.c_str()) != 0) {
    const std::string why = std::strerror(errno);
    std::remove(partial_.c_str());
    throw Error(path_, "", "cannot be written: " + why);
  }
}

void write_file(const std::string& path, std::string_view content) {
  AtomicFile file(path);
  file.write(content);
  file.commit();
}

std::string read_file(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) throw Error(path, "", std::strerror(errno));
  if (!S_ISREG(status.st_mode)) throw Error(path, "", "is not a regular file");
  std::FILE* file = std::fopen(path.c_str(), "rb");
  if (file == nullptr) throw Error(path, "", std::string("cannot be read: ") + std::strerror(errno));
  std::string content(static_cast<std::size_t>(status.st_size), '\0');
  const std::size_t got = std::fread(content.data(), 1, content.size(), file);
  std::fclose(file);
  if (got != content.size()) throw Error(path, "byte " + std::to_string(got), "cannot be read to its end");
  return content;
}

}  // namespace grtx
