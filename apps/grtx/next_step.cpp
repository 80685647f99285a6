// SPDX-License-Identifier: Apache-2.0
#include "grtx/apps/grtx/next_step.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "grtx/base/nearest_name.h"

namespace grtx::apps {
namespace {

namespace fs = std::filesystem;

/// Kinds of files that the program reads, recognised by content.
enum class Kind { unknown, folder, scene, cameras, trace, statistics, results, database, image, toml };

struct KindText {
  Kind kind;
  const char* is;    ///< description of the kind
  const char* goes;  ///< command that reads it
  const char* make;  ///< how to make one
};
constexpr std::array kKinds{
    KindText{Kind::scene, "a scene", "--scene takes it",
             "make one with 'grtx synth --preset object --count 60000 -o scene.ply', or see docs/guide/scenes.md"},
    KindText{
        Kind::cameras, "a camera file", "--cameras takes it",
        "'grtx synth' writes NAME.cameras.json beside a scene; trained models have a cameras.json in their folder"},
    KindText{Kind::trace, "a trace", "'grtx sim', 'trace-check' and 'trace-dump' take it",
             "make one with 'grtx trace --scene S --cameras C --accel tlas-tri20 --checkpoint on -o T.grtx'"},
    KindText{Kind::statistics, "the statistics of a run", "'grtx stalls' and 'grtx report' take it",
             "make one with 'grtx sim T.grtx --stats F.json'"},
    KindText{Kind::results, "the results of 'grtx run'", "'grtx report' and 'grtx stalls' take it",
             "make one with 'grtx run -o DIR'"},
    KindText{Kind::database, "a database of a sweep or search", "'grtx report' takes it, and 'grtx sweep -o'",
             "make one with 'grtx sweep PLAN.toml -o DB.sqlite'"},
    KindText{Kind::image, "an image", "'grtx compare' takes it", "make one with 'grtx trace --image'"},
    KindText{Kind::toml, "", "", "'grtx sim --list-config' prints all keys; configs/ has examples"},
    KindText{Kind::folder, "a folder", "give a file in it", ""},
};

const KindText* text_of(Kind kind) {
  const auto* found = std::ranges::find(kKinds, kind, &KindText::kind);
  return found == kKinds.end() ? nullptr : found;
}

Kind kind_of_json(const std::string& start) {
  const auto has = [&start](const char* word) { return start.find(word) != std::string::npos; };
  if (has("grtx.run/")) return Kind::results;
  if (has("grtx.stats/")) return Kind::statistics;
  if (has("\"lodLevels\"") || has("\"means\"") || has("\"asset\"")) return Kind::scene;
  if (has("\"frames\"") || (has("\"rotation\"") && has("\"fx\""))) return Kind::cameras;
  return has("\"file\"") ? Kind::scene : Kind::unknown;  // a list of objects
}

Kind kind_of(const std::string& path) {
  std::error_code failed;
  if (fs::is_directory(path, failed)) return Kind::folder;
  if (!fs::is_regular_file(path, failed)) return Kind::unknown;
  std::ifstream file(path, std::ios::binary);
  std::string start(4096, '\0');
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(file.gcount()));
  if (start.starts_with("\x93GRTX")) return Kind::trace;
  if (start.starts_with("ply") || start.starts_with("glTF") || start.starts_with("PK\x03\x04") ||
      start.starts_with("NGSP") || start.starts_with("\x1f\x8b"))
    return Kind::scene;
  if (start.starts_with("SQLite format 3")) return Kind::database;
  if (start.starts_with("\x89PNG") || start.starts_with("PF\n") || start.starts_with("\x76\x2f\x31\x01")) {
    return Kind::image;
  }
  const std::size_t first = start.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && (start[first] == '{' || start[first] == '[')) return kind_of_json(start);
  return Kind::unknown;
}

/// Kind of file expected at argument `at`, from the option before it or the command's positional arguments.
std::vector<Kind> wanted(const std::vector<std::string>& arguments, std::size_t at) {
  const std::string& option = at > 0 ? arguments[at - 1] : "";
  if (option == "--scene") return {Kind::scene};
  if (option == "--cameras") return {Kind::cameras};
  if (option == "--config" || option == "--machine") return {Kind::toml};
  if (option.starts_with("-") && option != "--quiet" && option != "--json") return {};
  const std::string& command = arguments.front();
  if (command == "sim" || command.starts_with("trace-")) return {Kind::trace};
  if (command == "info" || command == "convert") return {Kind::scene};
  if (command == "stalls") return {Kind::statistics, Kind::results};
  if (command == "report") return {Kind::results, Kind::statistics, Kind::database};
  if (command == "compare") return {Kind::image};
  if (command == "sweep" || command == "search") return {Kind::toml};
  return {};
}

/// A file in the same folder whose name differs by one or two letters.
std::string near_file(const std::string& path) {
  const fs::path folder = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : fs::path(".");
  const std::string name = fs::path(path).filename().string();
  std::vector<std::string> names;
  std::error_code failed;
  for (auto entry = fs::directory_iterator(folder, failed); !failed && entry != fs::directory_iterator();
       entry.increment(failed)) {
    const std::string other = entry->path().filename().string();
    const std::size_t difference = std::max(name.size(), other.size()) - std::min(name.size(), other.size());
    if (difference <= 2 && !other.empty() && !name.empty() && other.front() == name.front()) names.push_back(other);
  }
  std::ranges::sort(names);
  const std::string near = nearest_name(name, names);
  if (near.empty()) return "";
  return (fs::path(path).has_parent_path() ? folder / near : fs::path(near)).string();
}

/// The trained model in a folder with the layout of the original 3DGS code.
std::string scene_below(const std::string& folder) {
  for (const char* iteration : {"30000", "7000"}) {
    const fs::path model =
        fs::path(folder) / "point_cloud" / (std::string("iteration_") + iteration) / "point_cloud.ply";
    std::error_code failed;
    if (fs::is_regular_file(model, failed)) return model.string();
  }
  return "";
}

/// A .ply without Gaussians: COLMAP points (input.ply beside a trained model) or a mesh.
bool has_no_gaussians(const Error& error) {
  for (const char* words : {"needs the property \"f_dc_0\"", "holds no Gaussians"}) {
    if (error.rule().find(words) != std::string::npos) return true;
  }
  return false;
}

std::string of_file(const Error& error, const std::vector<std::string>& arguments, std::size_t at) {
  const std::string& path = arguments[at];
  const std::vector<Kind> kinds = wanted(arguments, at);
  std::error_code failed;
  if (error.rule().starts_with("must end in")) return "";  // the error is about an output file
  if (!fs::exists(path, failed)) {
    const fs::path parent = fs::path(path).parent_path();
    if (!parent.empty() && !fs::exists(parent, failed)) {
      return fmt::format("there is no folder {}: mkdir -p {}", parent.string(), parent.string());
    }
    if (kinds.empty()) return "";
    if (const std::string near = near_file(path); !near.empty()) return fmt::format("{} is there", near);
    return text_of(kinds.front())->make;
  }
  if (kinds.empty()) return "";
  const Kind is = kind_of(path);
  if (is == Kind::folder && kinds.front() == Kind::scene) {
    const std::string model = scene_below(path);
    return model.empty() ? "it is a folder: give the scene file in it" : fmt::format("the scene is {}", model);
  }
  if (is != Kind::unknown && std::ranges::find(kinds, is) == kinds.end()) {
    if (is == Kind::folder && kinds.front() == Kind::cameras) return text_of(Kind::cameras)->make;
    const KindText* text = text_of(is);
    return fmt::format("it is {}: {}", text->is, text->goes);
  }
  if (is == Kind::scene && has_no_gaussians(error)) {
    return "points and meshes alone are no scene: docs/guide/scenes.md says which file of a trained model is";
  }
  const bool of_memory = error.rule().find(" MB are free") != std::string::npos;  // base/free_memory.h
  const bool in_its_bytes = !of_memory && (error.place().starts_with("byte") || error.place().starts_with("line"));
  if (is == Kind::trace) return in_its_bytes ? "trace the view again with 'grtx trace'" : "";
  if (kinds.front() == Kind::toml || is == Kind::unknown) return text_of(kinds.front())->make;
  return in_its_bytes ? "the file may be cut or damaged: obtain it again" : "";
}

/// Position of the file among the arguments; if there are several, one where its kind is wrong. 0: not found.
std::size_t place_of(const std::string& file, const std::vector<std::string>& arguments) {
  std::size_t place = 0;
  for (std::size_t at = 1; at < arguments.size() && !file.starts_with("-"); ++at) {
    if (arguments[at] != file) continue;
    const std::vector<Kind> kinds = wanted(arguments, at);
    const bool wrong = !kinds.empty() && std::ranges::find(kinds, kind_of(file)) == kinds.end();
    if (place == 0 || wrong) place = at;
  }
  return place;
}

}  // namespace

std::string next_step(const Error& error, const std::vector<std::string>& arguments) {
  if (error.file() == "internal error" || arguments.empty()) return "";
  if (error.rule().find(std::strerror(EACCES)) != std::string::npos) return "";  // there, but not for this user
  if (error.rule().find("which is not read: ") != std::string::npos) return "";  // says what to do
  if (const std::size_t at = place_of(error.file(), arguments); at != 0) {
    if (std::string step = of_file(error, arguments, at); !step.empty()) return step;
  }
  // These messages already contain a hint.
  const std::string said = error.place() + " " + error.rule();
  for (const char* words :
       {"nearest", "known:", "grtx ", "the file has", "needed", "needs", "ends in", "end in", "must", "gives", "takes",
        "did you mean", "in its place", "is given", "in range", "cannot be written", "numbered from"}) {
    if (said.find(words) != std::string::npos) return "";
  }
  const std::string& command = arguments.front();
  if (command == "trace" && error.rule().find("has no Gaussians") != std::string::npos) return "--no-trace renders it";
  return command.starts_with("-") ? "see grtx --help" : fmt::format("see grtx {} --help", command);
}

}  // namespace grtx::apps
