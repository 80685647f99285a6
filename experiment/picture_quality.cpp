// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/picture_quality.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/gaussian/proxy.h"
#include "grtx/frontend/reference/reference.h"

namespace grtx::experiment {
namespace {

using nlohmann::ordered_json;

frontend::ReferenceProxy reference_proxy(frontend::AccelKind accel) {
  switch (frontend::proxy_of(accel)) {
    case frontend::ProxyKind::icosahedron20:
      return frontend::ReferenceProxy::icosahedron20;
    case frontend::ProxyKind::icosphere80:
      return frontend::ReferenceProxy::icosphere80;
    case frontend::ProxyKind::sphere:
      break;
  }
  return frontend::ReferenceProxy::sphere;
}

/// The reference in the order of a design.
frontend::ReferenceOptions reference_options(const TracerSettings& settings, frontend::AccelKind accel) {
  frontend::ReferenceOptions options;
  options.proxy = reference_proxy(accel);
  options.sort_by_peak = settings.options.sort_key == frontend::SortKey::peak;
  options.adaptive_radius = settings.kernel_radius == KernelRadius::adaptive;
  options.kernel_degree = settings.kernel_degree;
  options.ert = settings.options.ert;
  options.count_inside = settings.options.inside == frontend::InsideRule::count;
  options.sh_from_centre = settings.options.sh_direction == frontend::ShDirection::centre;
  options.threads = settings.threads;
  return options;
}

ordered_json decibels(const std::vector<double>& frames) {
  ordered_json list = ordered_json::array();
  for (const double psnr : frames) list.push_back(std::isinf(psnr) ? ordered_json() : ordered_json(psnr));
  return list;
}

}  // namespace

ordered_json picture_json(const PictureQuality& quality) {
  return {{"order", quality.order},
          {"reference", quality.fp64 ? "fp64" : "tracer"},
          {"reference_pixels", quality.pixels},
          {"psnr", decibels(quality.over)},
          {"psnr_reference", decibels(quality.reference)}};
}

std::string worst_picture(const ordered_json& decibels) {
  double worst = std::numeric_limits<double>::infinity();
  for (const ordered_json& psnr : decibels) {
    if (psnr.is_number()) worst = std::min(worst, psnr.get<double>());
  }
  return std::isinf(worst) ? "identical" : fmt::format("{:.1f} dB", worst);
}

double psnr_on(const frontend::Image& image, const frontend::Image& reference, const std::vector<std::size_t>& pixels) {
  const auto cut = [&pixels](const frontend::Image& whole) {
    frontend::Image part(static_cast<unsigned>(pixels.size()), 1);
    for (std::size_t i = 0; i < pixels.size(); ++i) part.pixels[i] = whole.pixels[pixels[i]];
    return part;
  };
  const double psnr =
      pixels.empty() ? frontend::compare(image, reference).psnr : frontend::compare(cut(image), cut(reference)).psnr;
  return std::isnan(psnr) ? 0.0 : psnr;
}

unsigned ReferencePictures::tiles_per_side(std::uint64_t gaussians, std::uint64_t most_pairs) {
  constexpr std::uint64_t kRays = std::uint64_t{frontend::kReferenceTile} * frontend::kReferenceTile;
  unsigned tiles = kMostTilesASide;
  while (tiles > 0 && kRays * tiles * tiles * gaussians > most_pairs) --tiles;
  return tiles;
}

const ReferencePictures::Frames& ReferencePictures::frames(const TracerSettings& settings, frontend::AccelKind accel) {
  frontend::ReferenceOptions options = reference_options(settings, accel);
  const auto [known, is_new] =
      frames_.try_emplace({static_cast<int>(options.proxy), options.sort_by_peak ? 1 : 0}, Frames());
  if (!is_new || scene_ == nullptr) return known->second;
  options.objects = optical_objects(settings.secondary, *scene_, cameras_.front());
  options.quiet = quiet_;
  options.tiles_a_side = tiles_per_side(scene_->size(), options.objects.empty() ? kMostPairs : kMostPairsOfObjects);
  if (options.tiles_a_side == 0) return known->second;
  for (const frontend::Camera& camera : cameras_) {
    frontend::ReferenceResult result = frontend::render_reference(*scene_, camera, options);
    known->second.images.push_back(std::move(result.image));
    known->second.pixels = std::move(result.rendered);  // the same of each frame
  }
  return known->second;
}

}  // namespace grtx::experiment
