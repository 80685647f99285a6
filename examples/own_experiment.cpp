// SPDX-License-Identifier: Apache-2.0
// What `grtx run` does, in a program of somebody's own: a scene and its cameras to designs, results and report.
//   own_experiment SCENE.ply CAMERAS.json FOLDER
#include <fmt/format.h>

#include <systemc>

#include "grtx/base/error.h"
#include "grtx/experiment/run_designs.h"

int sc_main(int argc, char** argv) {
  try {
    if (argc != 4) throw grtx::Error("own_experiment", "arguments", "SCENE CAMERAS FOLDER");
    grtx::experiment::set_machines_folder(grtx::kMachinesFolder);
    grtx::experiment::RunPlan plan = grtx::experiment::plan_on("paper-charged", {"gpu.sms=2"});
    plan.scene = argv[1];
    plan.view.cameras = argv[2];
    plan.view.width = plan.view.height = 32;
    plan.output = argv[3];
    const grtx::experiment::DesignResults results = run_designs(plan);
    fmt::print("grtx over {}: {:.3f}\n", results.comparison.reference(),
               results.json.at("speedup").at("grtx").get<double>());
    return results.sound() ? 0 : 1;
  } catch (const grtx::Error& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
