// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/ray_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "grtx/base/error.h"
#include "grtx/frontend/tracer/tracer.h"

namespace grtx::experiment {
namespace {

void choose(const traces::Reader& reader, std::uint64_t index, std::optional<std::uint32_t> pixel,
            std::vector<ChosenRays>& chosen) {
  ChosenRays next;
  reader.read(index, next.group);
  for (unsigned lane = 0; lane < next.group.rays.size(); ++lane) {
    const traces::Ray& ray = next.group.rays[lane];
    if (!ray.rounds.empty() && (!pixel || ray.pixel == *pixel)) next.lanes.push_back(lane);
  }
  if (!next.lanes.empty()) chosen.push_back(std::move(next));
}

void choose_pixel(const std::string& trace, const traces::Reader& reader, const RayChoice& choice,
                  std::vector<ChosenRays>& chosen) {
  const traces::Header& header = reader.header();
  const unsigned x = choice.pixel.at(0), y = choice.pixel.at(1);
  if (x >= header.width || y >= header.height) {
    throw Error(trace, place_of(choice),
                fmt::format("the image has {} x {} pixels, numbered from 0", header.width, header.height));
  }
  const std::size_t frames = std::max<std::size_t>(1, header.frame_groups.size());
  if (choice.frame >= frames) {
    throw Error(trace, fmt::format("--frame {}", choice.frame),
                fmt::format("the trace has {} frame{}, numbered from 0", frames, frames == 1 ? "" : "s"));
  }
  std::uint64_t begin = 0;
  for (std::uint32_t i = 0; i < choice.frame; ++i) begin += header.frame_groups[i];
  const std::uint64_t end = header.frame_groups.empty() ? header.groups : begin + header.frame_groups[choice.frame];
  const std::uint32_t pixel = y * header.width + x;
  const auto primary = frontend::map_pixels(header.width, header.height,
                                            header.warp_mapping == traces::WarpMapping::linear, header.warp_size);
  if (primary.size() > end - begin) {
    throw Error(trace, place_of(choice),
                fmt::format("an image of {} x {} pixels has {} warps, the trace {}", header.width, header.height,
                            primary.size(), end - begin));
  }
  for (std::size_t i = 0; i < primary.size(); ++i) {
    if (std::find(primary[i].begin(), primary[i].end(), pixel) != primary[i].end()) {
      choose(reader, begin + i, pixel, chosen);
    }
  }
  for (std::uint64_t i = begin + primary.size(); i < end; ++i) choose(reader, i, pixel, chosen);  // glass and mirrors
}

}  // namespace

std::string place_of(const RayChoice& choice) {
  return choice.warp ? fmt::format("--warp {}", *choice.warp)
                     : fmt::format("--pixel {},{}", choice.pixel.at(0), choice.pixel.at(1));
}

std::vector<ChosenRays> chosen_rays(const std::string& trace, const traces::Reader& reader, const RayChoice& choice) {
  std::vector<ChosenRays> chosen;
  if (!choice.warp) {
    choose_pixel(trace, reader, choice, chosen);
  } else if (*choice.warp < reader.group_count()) {
    choose(reader, *choice.warp, std::nullopt, chosen);
  } else {
    throw Error(trace, place_of(choice), fmt::format("the trace has {} warps, numbered from 0", reader.group_count()));
  }
  if (chosen.empty()) throw Error(trace, place_of(choice), "has no ray: nothing was traced there");
  return chosen;
}

}  // namespace grtx::experiment
