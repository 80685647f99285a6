// SPDX-License-Identifier: Apache-2.0
// What `grtx run` does, in a program of somebody's own: a scene and its cameras to designs, results and report.
//   own_study SCENE.ply CAMERAS.json FOLDER
#include <fmt/format.h>

#include <systemc>

#include "grtx/base/error.h"
#include "grtx/study/run_designs.h"

int sc_main(int argc, char** argv) {
  try {
    if (argc != 4) throw grtx::Error("own_study", "arguments", "SCENE CAMERAS FOLDER");
    grtx::study::set_machines_folder(grtx::kMachinesFolder);
    grtx::study::RunPlan plan = grtx::study::plan_on("paper-charged", {"gpu.sms=2"});
    plan.scene = argv[1];
    plan.view.cameras = argv[2];
    plan.view.width = plan.view.height = 32;
    plan.output = argv[3];
    const grtx::study::DesignResults results = run_designs(plan);
    fmt::print("grtx over {}: {:.3f}\n", results.comparison.reference(),
               results.json.at("speedup").at("grtx").get<double>());
    return results.sound() ? 0 : 1;
  } catch (const grtx::Error& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
