// SPDX-License-Identifier: Apache-2.0
// The options of glass and mirrors, as the command line knows them.
#pragma once

#include "grtx/experiment/option_rules.h"
#include "grtx/experiment/secondary_settings.h"

namespace grtx::experiment {

/// Calls visit(name, value, description[, rule]) for each option, in the order of --help.
template <typename Settings, typename Visit>
void visit_secondary(Settings& settings, Visit&& visit) {
  visit("secondary", settings.what, "Optical objects in the scene, which send secondary rays",
        OneOf{{"none", "glass", "mirror", "both"}});
  visit("glass", settings.glass, "Glass sphere x,y,z,r in file coordinates (default: placed by the seed)", ListOf{4});
  visit("mirror", settings.mirror,
        "Mirror cx,cy,cz,nx,ny,nz,w,h: centre, normal, width, height (default: placed by the seed)", ListOf{8});
  visit("glass-index", settings.glass_index, "Index of refraction of the glass", InRange{1.0, 4.0});
  visit("secondary-seed", settings.seed, "Seed of objects without a place of their own");
  visit("secondary-bounces", settings.bounces, "Surfaces that the light of a pixel may meet", InRange{1U, 64U});
}

}  // namespace grtx::experiment
