// SPDX-License-Identifier: Apache-2.0
// grtx reference: the double-precision brute-force renderer.
#include <memory>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/json_output.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/apps/grtx/tracer_cli.h"
#include "grtx/base/error.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/reference/reference.h"
#include "grtx/frontend/tracer/scene_tracer.h"

namespace grtx::apps {
namespace {

struct ReferenceArguments {
  std::string scene;
  experiment::ViewOptions view;
  std::string proxy = "icosahedron20";
  std::string accel;
  frontend::SortKey sort_key = frontend::SortKey::entry;
  experiment::KernelRadius kernel_radius = experiment::KernelRadius::adaptive;
  unsigned kernel_degree = 2;
  frontend::InsideRule inside = frontend::InsideRule::skip;
  frontend::ShDirection sh_dir = frontend::ShDirection::ray;
  experiment::SecondarySettings secondary;
  frontend::ReferenceOptions render;
  std::string output;
};

frontend::ReferenceProxy proxy_of(const std::string& proxy, const std::string& accel) {
  using frontend::ReferenceProxy;
  if (!accel.empty()) {
    switch (frontend::proxy_of(frontend::accel_from_name(accel))) {
      case frontend::ProxyKind::icosahedron20:
        return ReferenceProxy::icosahedron20;
      case frontend::ProxyKind::icosphere80:
        return ReferenceProxy::icosphere80;
      case frontend::ProxyKind::sphere:
        return ReferenceProxy::sphere;
    }
  }
  if (proxy == "sphere") return ReferenceProxy::sphere;
  return proxy == "icosphere80" ? ReferenceProxy::icosphere80 : ReferenceProxy::icosahedron20;
}

int render(ReferenceArguments options, const CommonOptions& common) {
  frontend::ReferenceOptions& render = options.render;
  render.proxy = proxy_of(options.proxy, options.accel);
  render.sort_by_peak = options.sort_key == frontend::SortKey::peak;
  render.adaptive_radius = options.kernel_radius == experiment::KernelRadius::adaptive;
  render.kernel_degree = options.kernel_degree;
  render.count_inside = options.inside == frontend::InsideRule::count;
  render.sh_from_centre = options.sh_dir == frontend::ShDirection::centre;
  render.quiet = common.quiet;
  if (render.count_inside && render.proxy != frontend::ReferenceProxy::sphere) {
    throw Error("reference", "--inside count", "needs --proxy sphere (or an --accel with sphere or ellipsoid proxies)");
  }
  experiment::check_secondary(options.secondary);
  frontend::check_image_name(options.output);
  FilesRead files;
  const frontend::Camera camera = experiment::select_camera(options.view, files);
  const frontend::Scene scene = frontend::load_flat_scene(options.scene, files, common.quiet);
  common.files.check(files);
  render.objects = experiment::optical_objects(options.secondary, scene, camera);
  frontend::write_image(options.output, frontend::render_reference(scene, camera, render).image);
  if (common.json) {
    nlohmann::ordered_json json = json_document("reference");
    json["image"] = options.output;
    json["width"] = camera.width;
    json["height"] = camera.height;
    print_json(json);
  }
  return 0;
}

}  // namespace

void add_reference(CLI::App& app, CommonOptions& common) {
  const auto options = std::make_shared<ReferenceArguments>();
  CLI::App* command = make_command(app, common, "reference", "Renders by brute force in double precision",
                                   [options, &common] { return render(*options, common); });
  command->add_option("--scene", options->scene, "Scene file (no default)")->type_name(kInputFile)->required();
  add_view_options(command, options->view);
  CLI::Option* proxy = command->add_option("--proxy", options->proxy, "Bounding geometry of a Gaussian")
                           ->check(one_of({"icosahedron20", "icosphere80", "sphere"}));
  command->add_option("--accel", options->accel, "Takes the proxy of this acceleration structure (default: none)")
      ->check(one_of(names_of<frontend::AccelKind>()))
      ->excludes(proxy);
  add_choice(command, "--sort-key", options->sort_key, "Distance that orders a ray's hits");
  add_choice(command, "--kernel-radius", options->kernel_radius,
             "Radius at which a Gaussian ends: by its opacity, or three standard deviations");
  add_kernel_degree(command, options->kernel_degree);
  command->add_option("--ert", options->render.ert, "Transmittance below which a ray ends")->check(in_range(0.0, 1.0));
  add_choice(command, "--inside", options->inside,
             "Gaussians whose proxy holds the ray origin: skipped, or hit at distance 0");
  add_choice(command, "--sh-dir", options->sh_dir, "Direction in which the spherical harmonics are evaluated");
  add_secondary_options(command, options->secondary);
  command->add_option("--threads", options->render.threads, "Threads; 0 takes all");
  command->add_option("-o,--output", options->output, "Image to write: .pfm, .exr or .png (no default)")
      ->type_name(kOutputFile)
      ->required();
}

}  // namespace grtx::apps
