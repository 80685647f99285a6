// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/scene/ply_writer.h"

#include <fmt/format.h>

#include <bit>
#include <cassert>

namespace grtx::frontend {
namespace {

static_assert(std::endian::native == std::endian::little, ".ply files are written little-endian");
constexpr std::size_t kBufferBytes = 1 << 20;

}  // namespace

PlyWriter::PlyWriter(const std::string& path, std::uint64_t rows, unsigned sh_degree)
    : file_(path), rows_(rows), coefficients_((sh_degree + 1) * (sh_degree + 1)) {
  buffer_ = fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", rows);
  const auto property = [&](const std::string& name) { buffer_ += "property float " + name + '\n'; };
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"}) property(name);
  for (unsigned i = 0; i < 3 * (coefficients_ - 1); ++i) property(fmt::format("f_rest_{}", i));
  for (const char* name : {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
    property(name);
  buffer_ += "end_header\n";
}

void PlyWriter::add(const PlyRow& row) {
  const auto put = [&](float value) { buffer_.append(reinterpret_cast<const char*>(&value), sizeof value); };
  for (int axis = 0; axis < 3; ++axis) put(row.position[axis]);
  for (int axis = 0; axis < 3; ++axis) put(0.0f);
  for (std::size_t c = 0; c < 3; ++c) put(row.sh[c]);
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t k = 1; k < coefficients_; ++k) put(row.sh[3 * k + c]);
  }
  put(row.opacity_logit);
  for (const float value : row.log_scale) put(value);
  for (const float value : row.rotation) put(value);
  ++added_;
  if (buffer_.size() >= kBufferBytes) {
    file_.write(buffer_);
    buffer_.clear();
  }
}

void PlyWriter::commit() {
  assert(added_ == rows_);
  file_.write(buffer_);
  file_.commit();
}

}  // namespace grtx::frontend
