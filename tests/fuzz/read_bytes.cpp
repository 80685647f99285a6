// SPDX-License-Identifier: Apache-2.0
#include "fuzz/readers.h"

#include <fcntl.h>
#include <unistd.h>

#include <filesystem>
#include <stdexcept>

#include "grtx/base/error.h"

namespace grtx::fuzzing {

namespace fs = std::filesystem;

const std::string& folder() {
  static const struct Folder {
    Folder() {
      const fs::path memory = fs::exists("/dev/shm") ? "/dev/shm" : fs::temp_directory_path();
      path = (memory / ("grtx_readers_" + std::to_string(::getpid()))).string();
      fs::create_directories(path);
    }
    ~Folder() { fs::remove_all(path); }
    std::string path;
  } made;
  return made.path;
}

bool read_bytes(const InputReader& reader, std::string bytes) {
  if (reader.repair != nullptr) reader.repair(bytes);
  const std::string own = folder() + "/" + reader.name;
  static std::string made;  // creating the folder for each input would take longer than reading it
  if (made != own) fs::create_directories(made = own);
  const std::string path = own + "/" + reader.file;
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  const bool written = file >= 0 && ::write(file, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size());
  if (file >= 0) ::close(file);
  if (!written) throw std::runtime_error(path + " cannot be written");
  try {
    reader.read(path);
    return true;
  } catch (const Error& error) {
    if (error.rule().empty()) throw std::runtime_error(reader.name + ": refused without a rule");
    return false;
  }
}

}  // namespace grtx::fuzzing
