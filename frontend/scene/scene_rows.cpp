// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/scene/scene_rows.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>

#include "grtx/base/error.h"
#include "grtx/base/free_memory.h"
#include "grtx/frontend/scene/float_rounding.h"

namespace grtx::frontend {
namespace {

constexpr double kMinScale = 1e-6;       // scene units; Mitsuba's ellipsoids clamp at the same value
constexpr double kMinNorm = 1e-12;       // of a quaternion
constexpr double kMaxCoordinate = 1e37;  // differences of two coordinates stay finite in float
constexpr double kMaxScale = 1e37;       // so do the corners of a proxy, 3.8 scales from the centre
constexpr double kUnitTolerance = 1e-3;  // on the norm of a quaternion
constexpr float kMinAlpha = 1.0f / 255.0f;

enum class Reason : std::uint8_t {
  kept,
  position,
  position_range,
  scale,
  scale_range,
  rotation,
  zero_rotation,
  opacity,
  opacity_zero,
  sh,
};

constexpr std::array<const char*, 10> kReasonText{"",
                                                  "non-finite position",
                                                  "position beyond 1e37",
                                                  "non-finite scale",
                                                  "exp(scale) beyond 1e37",
                                                  "non-finite rotation",
                                                  "quaternion norm < 1e-12",
                                                  "NaN opacity",
                                                  "opacity logit -infinity",
                                                  "non-finite SH coefficient"};

bool is_finite(float value) { return (std::bit_cast<std::uint32_t>(value) & 0x7f800000u) != 0x7f800000u; }

// The per-row values that several rules need; computed once.
struct Activated {
  std::array<double, 3> scale{};
  double rotation_norm = 0.0;
};

bool all_finite(const float* values, std::size_t count) {
  bool finite = true;
  for (std::size_t i = 0; i < count; ++i) finite &= is_finite(values[i]);
  return finite;
}

// The first rule that the row breaks, in the order of Reason.
Reason judge(const RawRows& rows, std::size_t i, std::size_t sh_stride, Activated& activated) {
  const std::array<double, 3> position{rows.x[i], rows.y[i], rows.z[i]};
  for (const double p : position) {
    if (!std::isfinite(p)) return Reason::position;
  }
  for (const double p : position) {
    if (std::abs(p) > kMaxCoordinate) return Reason::position_range;
  }
  const float* log_scale = &rows.log_scale[i * 3];
  if (!all_finite(log_scale, 3)) return Reason::scale;
  for (std::size_t a = 0; a < 3; ++a) activated.scale[a] = std::exp(static_cast<double>(log_scale[a]));
  for (const double s : activated.scale) {
    if (!(s <= kMaxScale)) return Reason::scale_range;
  }
  const float* q = &rows.rotation[i * 4];
  if (!all_finite(q, 4)) return Reason::rotation;
  double norm2 = 0.0;
  for (std::size_t a = 0; a < 4; ++a) norm2 += static_cast<double>(q[a]) * static_cast<double>(q[a]);
  activated.rotation_norm = std::sqrt(norm2);
  if (activated.rotation_norm < kMinNorm) return Reason::zero_rotation;
  const float logit = rows.opacity_logit[i];
  if (std::isnan(logit)) return Reason::opacity;
  if (logit == -std::numeric_limits<float>::infinity()) return Reason::opacity_zero;
  if (!all_finite(&rows.sh[i * sh_stride], sh_stride)) return Reason::sh;
  return Reason::kept;
}

// Median: the mean of the two middle values if their number is even. Reorders `values`.
double median(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*std::max_element(values.begin(), middle) + *middle);
}

// Offset of the scene; exactly representable in float.
glm::dvec3 median_centre(const std::vector<glm::dvec3>& centres) {
  glm::dvec3 result(0.0);
  std::vector<double> values(centres.size());
  for (glm::length_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < centres.size(); ++i) values[i] = centres[i][axis];
    result[axis] = round_to_float(median(values));
  }
  return result;
}

// Number of Gaussians that share their centre with an earlier one.
std::uint64_t coincident_centres(const std::vector<glm::vec3>& mean) {
  // Open addressing, at most half full; the slot holds row + 1.
  const std::size_t slots = std::bit_ceil(mean.size() * 2 + 1);
  std::vector<std::uint32_t> table(slots, 0);
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < mean.size(); ++i) {
    std::uint64_t hash = 0;
    for (glm::length_t axis = 0; axis < 3; ++axis) {
      hash ^= std::bit_cast<std::uint32_t>(mean[i][axis] + 0.0f);  // -0 and 0 are the same place
      hash *= 0x9e3779b97f4a7c15u;
      hash ^= hash >> 29;
    }
    std::size_t slot = static_cast<std::size_t>(hash) & (slots - 1);
    while (table[slot] != 0 && mean[table[slot] - 1] != mean[i]) slot = (slot + 1) & (slots - 1);
    if (table[slot] != 0) {
      ++count;
    } else {
      table[slot] = static_cast<std::uint32_t>(i + 1);
    }
  }
  return count;
}

void count(std::map<std::string, std::uint64_t>& where, const char* reason, std::uint64_t number) {
  if (number > 0) where[reason] += number;
}

/// Number of rows by outcome.
struct RowCounts {
  std::array<std::uint64_t, kReasonText.size()> dropped{};
  std::uint64_t small_scales = 0, opaque = 0, unacceptable = 0, off_unit = 0;
};

// Appends all properties of a kept row except its centre.
void keep_row(const RawRows& rows, std::size_t i, std::size_t sh_stride, const Activated& activated, Scene& scene,
              RowCounts& counts) {
  glm::vec3 scale;
  bool small = false;
  for (std::size_t a = 0; a < 3; ++a) {
    small |= activated.scale[a] < kMinScale;
    scale[static_cast<glm::length_t>(a)] = static_cast<float>(std::max(activated.scale[a], kMinScale));
  }
  counts.small_scales += small;
  scene.scale.push_back(scale);

  const float* q = &rows.rotation[i * 4];
  const double norm = activated.rotation_norm;
  const auto component = [&](std::size_t a) { return static_cast<float>(static_cast<double>(q[a]) / norm); };
  scene.rotation.emplace_back(component(0), component(1), component(2), component(3));  // w, x, y, z
  counts.off_unit += std::abs(norm - 1.0) > kUnitTolerance;

  const float logit = rows.opacity_logit[i];
  counts.opaque += logit == std::numeric_limits<float>::infinity();  // the formula below gives 1
  const float opacity = static_cast<float>(1.0 / (1.0 + std::exp(-static_cast<double>(logit))));
  counts.unacceptable += opacity <= kMinAlpha;
  scene.opacity.push_back(opacity);

  const float* sh = &rows.sh[i * sh_stride];
  scene.sh.insert(scene.sh.end(), sh, sh + sh_stride);
}

void report(const RowCounts& counts, Scene& scene) {
  for (std::size_t r = 1; r < counts.dropped.size(); ++r) {
    count(scene.report.dropped, kReasonText[r], counts.dropped[r]);
  }
  count(scene.report.clamped, "exp(scale) < 1e-6, set to 1e-6", counts.small_scales);
  count(scene.report.clamped, "opacity logit +infinity, opacity 1", counts.opaque);
  count(scene.report.noticed, "opacity <= 1/255 (can never be accepted)", counts.unacceptable);
  count(scene.report.noticed, "coincident centres", coincident_centres(scene.mean));
  count(scene.report.noticed, "quaternion norm off 1 by more than 1e-3", counts.off_unit);
}

}  // namespace

void RawRows::resize(std::size_t n) {
  x.resize(n);
  y.resize(n);
  z.resize(n);
  log_scale.resize(n * 3);
  rotation.resize(n * 4);
  opacity_logit.resize(n);
  sh.resize(n * 3 * (sh_degree + 1) * (sh_degree + 1));
}

void RawRows::require_memory_for(std::size_t more, const std::string& file) const {
  const std::size_t sh_bytes = sizeof(float) * 3 * (sh_degree + 1) * (sh_degree + 1);
  const std::size_t row = 3 * sizeof(double) + 8 * sizeof(float) + sh_bytes;
  const std::size_t in_scene = sizeof(glm::vec3) * 2 + sizeof(glm::quat) + sizeof(float) + sh_bytes;
  require_memory(more * row + (x.size() + more) * in_scene, file, std::to_string(x.size() + more) + " Gaussians");
}

Scene make_scene(const RawRows& rows, std::string name, std::string hash) {
  const std::size_t n = rows.x.size();
  const std::size_t sh_stride = std::size_t{3} * (rows.sh_degree + 1) * (rows.sh_degree + 1);
  assert(rows.y.size() == n && rows.z.size() == n && rows.log_scale.size() == 3 * n);
  assert(rows.rotation.size() == 4 * n && rows.opacity_logit.size() == n && rows.sh.size() == sh_stride * n);
  if (n >= std::numeric_limits<std::uint32_t>::max()) {
    throw Error(name, "", "has " + std::to_string(n) + " Gaussians; at most 2^32 - 2 can be numbered");
  }

  Scene scene;
  scene.name = std::move(name);
  scene.hash = std::move(hash);
  scene.sh_degree = rows.sh_degree;
  scene.report.rows = n;
  scene.report.noticed = rows.noticed;
  scene.mean.reserve(n);
  scene.scale.reserve(n);
  scene.rotation.reserve(n);
  scene.opacity.reserve(n);
  scene.sh.reserve(n * sh_stride);
  std::vector<glm::dvec3> centre;
  centre.reserve(n);

  RowCounts counts;
  Activated activated;
  for (std::size_t i = 0; i < n; ++i) {
    const Reason reason = judge(rows, i, sh_stride, activated);
    if (reason != Reason::kept) {
      ++counts.dropped[static_cast<std::size_t>(reason)];
      continue;
    }
    centre.emplace_back(rows.x[i], rows.y[i], rows.z[i]);
    keep_row(rows, i, sh_stride, activated, scene, counts);
  }

  scene.offset = median_centre(centre);
  for (const glm::dvec3& c : centre) scene.mean.emplace_back(c - scene.offset);
  report(counts, scene);
  return scene;
}

}  // namespace grtx::frontend
