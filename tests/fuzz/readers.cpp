#include "fuzz/readers.h"

#include <fcntl.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "explore/sweep/fake_tracer_rules.h"
#include "frontend/scene/scene_bytes.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/explore/report/run_results.h"
#include "grtx/explore/report/sweep_results.h"
#include "grtx/explore/search/search_plan.h"
#include "grtx/explore/sweep/database.h"
#include "grtx/explore/sweep/plan.h"
#include "grtx/explore/sweep/task.h"
#include "grtx/frontend/accel/object_list.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/scene/scene_io.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/regress/regression_case.h"
#include "grtx/rtl_tlm/run/statistics_json.h"
#include "grtx/traces/check.h"
#include "grtx/traces/reader.h"
#include "paths.h"
#include "sweep_database.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::fuzzing {
namespace {

namespace fs = std::filesystem;
using frontend::test::Bytes;

using Seeds = std::vector<std::string>;
Seeds one(const std::string& text) { return {text}; }

/// A folder in memory, of this process.
const std::string& folder() {
  static const struct Folder {
    Folder() {
      const fs::path memory = fs::exists("/dev/shm") ? "/dev/shm" : fs::temp_directory_path();
      path = (memory / ("grtx_readers_" + std::to_string(::getpid()))).string();
      fs::create_directories(path);
    }
    ~Folder() { fs::remove_all(path); }
    std::string path;
  } made;
  return made.path;
}

std::string source_file(const std::string& name) { return read_file(grtx::paths::source_dir() + "/" + name); }

/// The converters' files of tests/data with an extension.
Seeds converted(const std::string& end) {
  Seeds files;
  for (const auto& entry : fs::directory_iterator(grtx::paths::source_dir() + "/tests/data/converters")) {
    const std::string path = entry.path().string();
    if (path.ends_with(end)) files.push_back(read_file(path));
  }
  return files;
}

/// As the 3DGS authors' program writes it, SH degree 0.
Seeds plain_ply() {
  std::string header = "ply\nformat binary_little_endian 1.0\nelement vertex 3\n";
  Bytes rows;
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0",
                           "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"}) {
    header += std::string("property float ") + name + "\n";
    for (int i = 0; i < 3; ++i) rows.add(0.25F * static_cast<float>(i + 1));
  }
  return {header + "end_header\n" + rows.str()};
}

template <class Number>
Number number_at(const std::string& bytes, std::size_t at) {
  Number value = 0;
  if (at + sizeof value <= bytes.size()) std::memcpy(&value, &bytes[at], sizeof value);
  return value;
}
void put_hash(std::string& bytes, std::size_t at, std::size_t from, std::size_t count) {
  if (at + 8 > bytes.size() || from > bytes.size() || count > bytes.size() - from) return;
  const std::uint64_t hash = xxh3(bytes.data() + from, count);
  std::memcpy(&bytes[at], &hash, sizeof hash);
}

/// docs/model/trace-format.md, "File".
void repair_trace(std::string& bytes) {
  if (bytes.size() < 60) return;
  put_hash(bytes, 16, 24, number_at<std::uint32_t>(bytes, 12));
  const auto footer = number_at<std::uint64_t>(bytes, bytes.size() - 16);
  const std::size_t end = bytes.size() - 16;
  if (footer > end || end - footer < 28) return;
  const auto chunks = number_at<std::uint64_t>(bytes, footer);
  for (std::uint64_t i = 0; i < std::min<std::uint64_t>(chunks, (end - footer - 8) / 8); ++i) {
    const auto chunk = number_at<std::uint64_t>(bytes, footer + 8 + 8 * i);
    if (chunk < footer) put_hash(bytes, chunk + 4, chunk + 12, number_at<std::uint32_t>(bytes, chunk));
  }
  put_hash(bytes, end - 16, 0, end - 16);
  put_hash(bytes, end - 8, footer, end - 8 - footer);
}

std::string trace_of(bool two_level) {
  traces::testing::RandomOptions options;
  options.seed = 3;
  options.two_level = options.checkpoint = two_level;
  options.capacity = two_level ? 1000 : 0;
  const traces::testing::RandomTrace trace = traces::testing::random_trace(options);
  const std::string path = folder() + "/seed.grtx";
  traces::testing::write_trace(path, trace.header, trace.groups);
  return read_file(path);
}

std::string image_of(const std::string& end) {
  frontend::Image image(7, 5);
  for (unsigned i = 0; i < 35; ++i) image.pixels[i] = glm::vec3(0.02f * static_cast<float>(i));
  frontend::write_image(folder() + "/seed." + end, image);
  return read_file(folder() + "/seed." + end);
}

std::string colmap_cameras() {
  Bytes cameras;
  cameras.add(std::uint64_t{1}).add(std::int32_t{7}).add(std::int32_t{1});
  cameras.add(std::uint64_t{640}).add(std::uint64_t{480});
  for (const double p : {500.0, 501.0, 320.0, 240.0}) cameras.add(p);
  return cameras.str();
}
std::string colmap_images() {
  Bytes images;
  images.add(std::uint64_t{1}).add(std::int32_t{1});
  for (const double v : {1.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0}) images.add(v);
  images.add(std::int32_t{7}).text("a.png").u8(0).add(std::uint64_t{1});
  images.add(1.0).add(2.0).add(std::int64_t{-1});
  return images.str();
}

std::string database() {
  const std::string path = folder() + "/seed.sqlite";
  fs::remove(path);
  testing_sweep::make_points(path, {{{"id", 1}, {"values", {{"gpu.time_us", 2.0}, {"cost.mm2", 3.0}}}}});
  return read_file(path);
}

constexpr const char* kStatistics =
    R"({"schema": "grtx.stats/1", "config": {"gpu.sms": 2}, "inputs": {"accel": "tri20", "checkpoint": "off"}, )"
    R"("stats": {"gpu.cycles": {"value": 12, "unit": "cycles", "description": "d"}, )"
    R"("gpu.rt.stall.memory": {"value": 1.5, "unit": "cycles", "description": ""}}})";

void scene(const std::string& path) { (void)frontend::load_scene(path); }
void cameras(const std::string& path) { (void)frontend::load_cameras(path); }
void image(const std::string& path) { (void)frontend::read_image(path); }
void colmap(const std::string& path) {
  const std::string own = fs::path(path).parent_path().string();
  if (!fs::exists(own + "/cameras.bin")) write_file(own + "/cameras.bin", colmap_cameras());
  if (!fs::exists(own + "/images.bin")) write_file(own + "/images.bin", colmap_images());
  (void)frontend::load_cameras(own);
}

}  // namespace

const std::vector<InputReader>& input_readers() {
  static const std::vector<InputReader> all = {
      {"ply", "s.ply", scene, nullptr, plain_ply},
      {"compressed_ply", "p.ply", scene, nullptr, [] { return converted(".compressed.ply"); }},
      {"splat", "s.splat", scene, nullptr, [] { return converted(".splat"); }},
      {"spz", "s.spz", scene, nullptr, [] { return converted(".spz"); }},
      {"glb", "s.glb", scene, nullptr, [] { return converted(".glb"); }},
      {"sog", "s.sog", scene, nullptr, [] { return converted(".sog"); }},
      {"cameras_json", "cameras.json", cameras, nullptr,
       [] {
         return one(R"([{"id": 0, "img_name": "a", "width": 64, "height": 48, "position": [0.5, 1, -2], )"
                    R"("rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "fy": 50.5, "fx": 50.25}])");
       }},
      {"transforms_json", "transforms.json", cameras, nullptr,
       [] {
         return one(R"({"fl_x": 50, "fl_y": 51, "cx": 32, "cy": 24, "w": 64, "h": 48, "frames": [{"file_path": )"
                    R"("a", "transform_matrix": [[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 2], [0, 0, 0, 1]]}]})");
       }},
      {"colmap_cameras", "cameras.bin", colmap, nullptr, [] { return Seeds{colmap_cameras()}; }},
      {"colmap_images", "images.bin", colmap, nullptr, [] { return Seeds{colmap_images()}; }},
      {"object_list", "objects.json", [](const std::string& path) { (void)frontend::load_object_list(path); }, nullptr,
       [] {
         return one(R"([{"file": "a.ply", "translate": [0, 1, 2.5], "rotate": [1, 0, 0, 0], "scale": 2}, )"
                    R"({"file": "b.ply"}])");
       }},
      {"png", "i.png", image, nullptr, [] { return Seeds{image_of("png")}; }},
      {"exr", "i.exr", image, nullptr, [] { return Seeds{image_of("exr")}; }},
      {"pfm", "i.pfm", image, nullptr, [] { return Seeds{image_of("pfm")}; }},
      {"configuration", "c.toml", [](const std::string& path) { (void)sim::load_config(path, {}); }, nullptr,
       [] { return Seeds{source_file("configs/paper.toml")}; }},
      {"plan", "p.toml",
       [](const std::string& path) {
         static const sim::test::FakeTracerRules tracer;
         (void)sim::load_plan(path, tracer);
       },
       nullptr,
       [] {
         return one(
             "designs = ['baseline', 'grtx']\nmode = 'fast'\nconfirm = 'cycle'\n[[scene]]\npreset = 'object'\ncount = "
             "100\nviews = [0, 1]\nwidth = 8\n[set]\ngpu.sms = 2\n[tracer]\nk = 8\n[limits]\nseconds = 5\n[grid]\n"
             "l1.latency = {from = 10, to = 40, steps = 3, integer = true}\n[random]\ncount = 5\nseed = 3\n"
             "[random.axes]\nl2.latency = [100, 200]\n");
       }},
      {"search_plan", "q.toml",
       [](const std::string& path) {
         static const sim::test::FakeTracerRules tracer;
         (void)sim::load_search_plan(path, tracer);
       },
       nullptr,
       [] {
         return one(
             "[[scene]]\npreset = 'object'\ncount = 100\n[[parameter]]\nkey = 'l1.latency'\nvalues = [10, 20]\n"
             "[[objective]]\nvalue = 'gpu.time_us'\n[[constraint]]\nrule = 'cost.mm2 <= 1.5 * reference'\n"
             "[reference]\nl1.latency = 20\n[search]\ngenerations = 2\npopulation = 8\nseed = 1\n");
       }},
      {"case", "a.case.toml",
       [](const std::string& path) { (void)sim::load_regression(fs::path(path).parent_path().string()); }, nullptr,
       [] {
         return one(
             "trace = 'a.grtx'\nmachine = 'paper'\nset = ['gpu.sms=2']\nmode = 'sampled'\nshare = 0.5\n"
             "seed = 2\nstatistics = ['gpu.*']\n[tolerance]\n'gpu.l1.*' = 0.1\n[[update]]\n"
             "date = 2026-11-23\nreason = 'x'\n");
       }},
      {"statistics", "s.json", [](const std::string& path) { (void)sim::read_statistics(path); }, nullptr,
       [] { return Seeds{kStatistics}; }},
      {"run_results", "r.json", [](const std::string& path) { (void)sim::read_run_results(path); }, nullptr,
       [] { return Seeds{kStatistics}; }},
      {"task_result", "k.json", [](const std::string& path) { (void)sim::read_outcome(path); }, nullptr,
       [] {
         return one(R"({"key": "k", "kind": "point", "status": "failed", "reason": "r", "seconds": 1.5, )"
                    R"("bytes": 3})");
       }},
      {"database", "d.sqlite", [](const std::string& path) { (void)sim::read_sweep_results(path); }, nullptr,
       [] { return Seeds{database()}; }},
      {"database_filled", "w.sqlite", [](const std::string& path) { (void)sim::SweepDatabase(path).meta("plan"); },
       nullptr, [] { return Seeds{database()}; }},
      {"trace", "t.grtx", [](const std::string& path) { traces::check(traces::Reader(path), true); }, repair_trace,
       [] { return Seeds{trace_of(true)}; }},
      {"trace_monolithic", "m.grtx", [](const std::string& path) { traces::check(traces::Reader(path), true); },
       repair_trace, [] { return Seeds{trace_of(false)}; }},
  };
  return all;
}

bool read_bytes(const InputReader& reader, std::string bytes) {
  if (reader.repair != nullptr) reader.repair(bytes);
  const std::string own = folder() + "/" + reader.name;
  static std::string made;  // creating the folder for each input would take longer than reading it
  if (made != own) fs::create_directories(made = own);
  const std::string path = own + "/" + reader.file;
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  const bool written = file >= 0 && ::write(file, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size());
  if (file >= 0) ::close(file);
  if (!written) throw std::runtime_error(path + " cannot be written");
  try {
    reader.read(path);
    return true;
  } catch (const Error& error) {
    if (error.rule().empty()) throw std::runtime_error(reader.name + ": refused without a rule");
    return false;
  }
}

}  // namespace grtx::fuzzing
