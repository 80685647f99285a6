// SPDX-License-Identifier: Apache-2.0
// grtx compare: differences between two images.
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/json_output.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/frontend/image/image.h"

namespace grtx::apps {
namespace {

struct CompareOptions {
  std::string a, b;
  double min_psnr = 0.0;
};

int compare_images(const CompareOptions& options, bool as_json) {
  const frontend::Image a = frontend::read_image(options.a);
  const frontend::Image b = frontend::read_image(options.b);
  const frontend::Comparison result = frontend::compare(a, b);
  const bool holds = result.psnr >= options.min_psnr;  // infinity passes any limit, NaN none
  if (as_json) {
    nlohmann::ordered_json json = json_document("compare");
    json["a"] = options.a;
    json["b"] = options.b;
    // JSON has no infinity or NaN: psnr is null for identical images, and for images with NaN, which are not identical.
    json["psnr"] = std::isfinite(result.psnr) ? nlohmann::ordered_json(result.psnr) : nlohmann::ordered_json(nullptr);
    json["max_error"] = result.max_error;
    json["mean_error"] = result.mean_error;
    json["different_pixels"] = result.different_pixels;
    json["pixels"] = a.pixels.size();
    json["identical"] = result.identical();
    print_json(json);
  } else {
    say("PSNR {:.4f} dB, max error {:.6g}, mean error {:.6g}, {} of {} pixels differ{}", result.psnr, result.max_error,
        result.mean_error, result.different_pixels, a.pixels.size(), result.identical() ? " (identical)" : "");
  }
  if (!holds) {
    fmt::print(stderr, "grtx: compare: PSNR {:.4f} dB is below the required {} dB\n", result.psnr, options.min_psnr);
    return 1;
  }
  return 0;
}

}  // namespace

void add_compare(CLI::App& app, CommonOptions& common) {
  const auto options = std::make_shared<CompareOptions>();
  CLI::App* command = make_command(app, common, "compare", "Compares two images of equal size",
                                   [options, &common] { return compare_images(*options, common.json); });
  command->add_option("A", options->a, "First image: .png, .exr or .pfm")->type_name(kInputFile)->required();
  command->add_option("B", options->b, "Second image")->type_name(kInputFile)->required();
  command->add_option("--min-psnr", options->min_psnr, "Exit 1 when the PSNR in dB is below this");
}

}  // namespace grtx::apps
