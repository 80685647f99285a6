// SPDX-License-Identifier: Apache-2.0
// Writes rows as an INRIA .ply, streaming.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>

#include "grtx/base/atomic_file.h"

namespace grtx::frontend {

/// One Gaussian as the file stores it.
struct PlyRow {
  glm::vec3 position{0.0f};
  std::array<float, 3> log_scale{};     ///< natural logarithm
  std::array<float, 4> rotation{1.0f};  ///< w x y z, any norm
  float opacity_logit = 0.0f;
  std::array<float, 48> sh{};  ///< coefficient-major, r g b inner; the first (degree + 1)^2 are used
};

class PlyWriter {
 public:
  /// Little-endian binary with zero normals; f_rest channel-major. Throws Error when the file cannot be written.
  PlyWriter(const std::string& path, std::uint64_t rows, unsigned sh_degree);
  void add(const PlyRow& row);
  /// Finishes the file; all `rows` must have been added.
  void commit();

 private:
  AtomicFile file_;
  std::string buffer_;
  std::uint64_t rows_;
  std::uint64_t added_ = 0;
  unsigned coefficients_;
};

}  // namespace grtx::frontend
