// SPDX-License-Identifier: Apache-2.0
#include <zstd.h>

#include <cstdlib>
#include <stdexcept>

#include "fuzz/readers.h"
#include "grtx/base/atomic_file.h"
#include "paths.h"

namespace grtx::fuzzing {

std::vector<std::string> corpus(const InputReader& reader) {
  const std::string path = paths::source_dir() + "/tests/fuzz/corpus/" + reader.name + ".tar.zst";
  const std::string packed = read_file(path);
  const unsigned long long bytes = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (bytes > 100'000'000) throw std::runtime_error(path + " does not say how long it is, or is damaged");
  std::string tar(static_cast<std::size_t>(bytes), '\0');
  if (ZSTD_decompress(tar.data(), tar.size(), packed.data(), packed.size()) != tar.size()) {
    throw std::runtime_error(path + " is damaged");
  }
  // A file is a block of 512 bytes, its size in octal digits at 124, then its bytes in whole blocks; a name of zeros
  // ends.
  std::vector<std::string> inputs;
  for (std::size_t at = 0; at + 512 <= tar.size() && tar[at] != '\0';) {
    const std::size_t size = std::strtoull(tar.substr(at + 124, 12).c_str(), nullptr, 8);
    inputs.push_back(tar.substr(at + 512, size));
    at += 512 + (size + 511) / 512 * 512;
  }
  return inputs;
}

}  // namespace grtx::fuzzing
