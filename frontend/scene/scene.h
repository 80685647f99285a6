// SPDX-License-Identifier: Apache-2.0
// A Gaussian scene in memory: activated parameters, structure of arrays, recentred.
#pragma once

#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <string>
#include <vector>

namespace grtx::frontend {

/// Non-zero counts of what loading dropped, clamped or noticed, by reason (e.g. "dropped: non-finite position").
struct LoadReport {
  std::uint64_t rows = 0;  ///< rows in the file
  std::map<std::string, std::uint64_t> dropped;
  std::map<std::string, std::uint64_t> clamped;
  std::map<std::string, std::uint64_t> noticed;
};

/// All vectors have size() entries, `sh` has size() * sh_coefficients() * 3.
struct Scene {
  std::vector<glm::vec3> mean;      ///< scene units, relative to `offset`
  std::vector<glm::vec3> scale;     ///< standard deviations, scene units, > 0
  std::vector<glm::quat> rotation;  ///< unit; local to world
  std::vector<float> opacity;       ///< 0..1
  std::vector<float> sh;            ///< Gaussian-major, then coefficient, then r g b
  unsigned sh_degree = 0;           ///< 0..4
  glm::dvec3 offset{0.0};           ///< added to `mean` gives the file's coordinates
  std::string name;                 ///< file name or generator preset
  std::string hash;                 ///< XXH3 of the input bytes, hexadecimal
  LoadReport report;

  std::size_t size() const { return mean.size(); }
  unsigned sh_coefficients() const { return (sh_degree + 1) * (sh_degree + 1); }
};

}  // namespace grtx::frontend
