// SPDX-License-Identifier: Apache-2.0
// Makes a small room and renders it through the tracer, with a trace of what the rays did:
//   render ROOM.ply IMAGE.pfm TRACE.grtx
#include <cstdio>
#include <exception>
#include <string>

#include "grtx/base/error.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/scene/scene_io.h"
#include "grtx/frontend/synth/synth.h"
#include "grtx/frontend/tracer/view_tracer.h"

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "render ROOM.ply IMAGE.pfm TRACE.grtx\n");
    return 2;
  }
  using namespace grtx::frontend;
  try {
    const std::string room = argv[1];
    SynthOptions synth{.preset = "flat", .count = 3000, .seed = 7};
    synthesise(synth, room);

    const Scene scene = load_scene(room);
    const std::string cameras = room.substr(0, room.size() - 4) + ".cameras.json";
    const Camera camera = load_cameras(cameras).at(0).resized(48, 32);
    TracerOptions options;
    options.checkpoint = true;
    AccelOptions accel_options{.kind = AccelKind::tlas_tri20};

    ViewTracer tracer(scene, camera, options.kernel);
    tracer.build(accel_options);
    const RenderResult result = tracer.trace(options, RenderOptions(), argv[3]).result;
    write_image(argv[2], result.image);

    std::printf("%zu Gaussians, %llu rays, %llu blended\n", scene.size(),
                static_cast<unsigned long long>(result.counters.rays),
                static_cast<unsigned long long>(result.counters.blended));
    return result.counters.rays == 48U * 32U && result.counters.blended > 0 ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "render: %s\n", error.what());
    return 2;
  }
}
