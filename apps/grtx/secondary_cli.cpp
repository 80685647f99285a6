#include "grtx/apps/grtx/secondary_cli.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "grtx/apps/grtx/options.h"
#include "grtx/base/error.h"

namespace grtx::sim {

using namespace frontend;

void add_secondary_options(CLI::App* command, SecondaryCli& cli) {
  command->add_option("--secondary", cli.what, "Optical objects in the scene, which send secondary rays")
      ->check(one_of({"none", "glass", "mirror", "both"}));
  command->add_option("--glass", cli.glass, "Glass sphere x,y,z,r in file coordinates (default: placed by the seed)")
      ->delimiter(',')
      ->expected(4);
  command
      ->add_option("--mirror", cli.mirror,
                   "Mirror cx,cy,cz,nx,ny,nz,w,h: centre, normal, width, height (default: placed by the seed)")
      ->delimiter(',')
      ->expected(8);
  command->add_option("--glass-index", cli.glass_index, "Index of refraction of the glass")->check(in_range(1.0, 4.0));
  command->add_option("--secondary-seed", cli.seed, "Seed of objects without a place of their own");
  command->add_option("--secondary-bounces", cli.bounces, "Surfaces that the light of a pixel may meet")
      ->check(in_range(1U, 64U));
}

OpticalObjects optical_objects(const SecondaryCli& cli, const Scene& scene, const Camera& camera) {
  const bool glass = cli.what == "glass" || cli.what == "both";
  const bool mirror = cli.what == "mirror" || cli.what == "both";
  if (!cli.glass.empty() && !glass) throw Error("--glass", "", "needs --secondary glass or both");
  if (!cli.mirror.empty() && !mirror) throw Error("--mirror", "", "needs --secondary mirror or both");
  OpticalObjects objects;
  if ((glass && cli.glass.empty()) || (mirror && cli.mirror.empty())) {
    objects = place_at_random(scene, camera, glass, mirror, cli.glass_index, cli.seed);
  }
  if (!cli.glass.empty()) {
    const auto& g = cli.glass;
    objects.glass = make_glass({g[0], g[1], g[2]}, g[3], cli.glass_index);
  }
  if (!cli.mirror.empty()) {
    const auto& m = cli.mirror;
    objects.mirror = make_mirror({m[0], m[1], m[2]}, {m[3], m[4], m[5]}, m[6], m[7]);
  }
  objects.max_bounces = cli.bounces;
  check_apart(objects);
  return objects;
}

std::map<std::string, std::string> secondary_inputs(const SecondaryCli& cli) {
  std::map<std::string, std::string> inputs = {{"secondary", cli.what}};
  if (cli.what == "none") return inputs;
  inputs["secondary_seed"] = std::to_string(cli.seed);
  inputs["secondary_bounces"] = std::to_string(cli.bounces);
  inputs["glass_index"] = fmt::format("{}", cli.glass_index);
  return inputs;
}

std::map<std::string, std::string> placed_inputs(const SecondaryCli& cli) {
  std::map<std::string, std::string> inputs;
  if (!cli.glass.empty()) inputs["placed_glass"] = fmt::format("{}", fmt::join(cli.glass, ","));
  if (!cli.mirror.empty()) inputs["placed_mirror"] = fmt::format("{}", fmt::join(cli.mirror, ","));
  return inputs;
}

std::map<std::string, std::string> object_inputs(const OpticalObjects& objects) {
  std::map<std::string, std::string> inputs;
  if (objects.glass) {
    const GlassSphere& g = *objects.glass;
    inputs["glass"] = fmt::format("{},{},{},{}", g.centre.x, g.centre.y, g.centre.z, g.radius);
  }
  if (objects.mirror) {
    const Mirror& m = *objects.mirror;
    inputs["mirror"] = fmt::format("{},{},{},{},{},{},{},{}", m.centre.x, m.centre.y, m.centre.z, m.normal.x,
                                   m.normal.y, m.normal.z, m.width, m.height);
  }
  return inputs;
}

std::string describe(const OpticalObjects& objects) {
  std::vector<std::string> parts;
  for (const auto& [name, place] : object_inputs(objects)) parts.push_back(fmt::format("--{} {}", name, place));
  return fmt::format("{}", fmt::join(parts, " "));
}

}  // namespace grtx::sim
