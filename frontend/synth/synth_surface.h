// SPDX-License-Identifier: Apache-2.0
// The geometry that generated Gaussians lie on: patches of simple surfaces, each with a texture.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "grtx/frontend/numbers/counter_random.h"

namespace grtx::frontend {

enum class SynthShape {
  quad,       ///< origin + a u + b v
  ellipsoid,  ///< origin + a x + b y + c z on the unit sphere
  cylinder,   ///< origin + a cos + b sin + t c
  ground,     ///< quad with gentle hills along its normal
  leaves,     ///< small discs scattered in an ellipsoid
  haze        ///< an ellipsoid's whole volume, no surface
};

enum class SynthPattern { plain, mottled, planks, tiles, bricks, stripes, books, picture };

struct SynthTexture {
  SynthPattern pattern = SynthPattern::plain;
  glm::dvec3 first{0.5}, second{0.5};  ///< linear colours 0..1
  double size = 0.1;                   ///< of the pattern, scene units
};

struct SynthPatch {
  SynthShape shape = SynthShape::quad;
  SynthTexture texture;
  glm::dvec3 origin{0.0}, a{1, 0, 0}, b{0, 1, 0}, c{0, 0, 1};
  glm::dvec3 pattern_origin{0.0};  ///< so that tiles of one wall share a pattern
  double whole_a = 0.0,
         whole_b = 0.0;        ///< lengths of the rectangle that contains this cell; it begins at pattern_origin
  glm::dvec3 grain{0.0};       ///< preferred direction of the longest axis; zero: none
  double leaf_radius = 0.05;   ///< leaves only
  double detail = 0.0;         ///< added to ln(d8): negative is denser
  double opacity_shift = 0.0;  ///< added to the opacity logit
  std::uint32_t object = 0;    ///< patches of one object share its colour shift
  double area = 0.0;           ///< set by SynthLayout; haze: volume^(2/3)
};

struct SynthPoint {
  glm::dvec3 position{0.0};
  glm::dvec3 normal{0, -1, 0};  ///< unit, towards the side that is seen; zero in a haze
  double noise = 0.0;           ///< -1 .. 1, smooth along the object
};

/// A point of the patch, uniform in area except for the ellipsoid's stretch. `leaves`: number of discs of a clump.
SynthPoint sample_patch(const SynthPatch& patch, std::uint64_t seed, std::uint64_t leaves, CounterRandom& random);
/// Texture colour, 0..1, without lighting. `footprint`: extent over which it is averaged, scene units.
glm::dvec3 patch_colour(const SynthPatch& patch, const SynthPoint& point, double footprint, std::uint64_t seed);

/// Collects patches. Large rectangles are split into cells of about `cell` scene units.
class SynthLayout {
 public:
  /// Patches added from now on belong to a new object, with one colour shift and these values.
  SynthPatch& style(SynthTexture texture, double detail = 0.0);
  void quad(glm::dvec3 origin, glm::dvec3 a, glm::dvec3 b, double cell = 1.2);
  void ground(glm::dvec3 origin, glm::dvec3 a, glm::dvec3 b, double cell);
  /// A box, by the centre of its bottom and its full size; y points down. `bottom`: with the lower face.
  void box(glm::dvec3 foot, glm::dvec3 size, bool bottom = false);
  void ellipsoid(glm::dvec3 centre, glm::dvec3 radii);
  void cylinder(glm::dvec3 from, glm::dvec3 to, double radius);
  void leaves(glm::dvec3 centre, glm::dvec3 radii, double leaf_radius);
  void haze(glm::dvec3 centre, glm::dvec3 radii);

  /// Reduces ln(d8) of the patches from index `first` on by `by`.
  void refine(std::size_t first, double by);

  const std::vector<SynthPatch>& patches() const { return patches_; }

 private:
  void add(SynthPatch patch, double area);

  SynthPatch style_;
  std::vector<SynthPatch> patches_;
};

}  // namespace grtx::frontend
