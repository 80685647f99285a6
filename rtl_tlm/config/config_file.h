// SPDX-License-Identifier: Apache-2.0
// Configuration files: where those of the project's machines lie, and how files, designs and `--set` are applied in
// order to a list of keys.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "grtx/modules/kernel/declare.h"

namespace grtx {

#ifdef GRTX_MACHINES_FOLDER  // comes with the target grtx::sim
/// Folder of the project's machines, for set_machines_folder().
inline constexpr const char* kMachinesFolder = GRTX_MACHINES_FOLDER;
#endif

}  // namespace grtx

namespace grtx::sim {

/// Machine used when nobody names one; GpuConfig() is this machine, too.
inline constexpr const char* kDefaultMachine = "paper";

/// Sets the folder with the project's machines. It is used only if no machines are installed beside the program.
void set_machines_folder(const std::string& folder);
/// Names of all machines of the project, sorted.
std::vector<std::string> machine_names();
/// The file of a machine: of the project's by its name; a path that ends in .toml is that path. Throws Error.
std::string machine_file(const std::string& machine);

/// Place where a key is set. comment: the comment behind the key on its line, by habit the value's source. Places that
/// are no file ("--set", "--design walk") have no line.
struct KeyPlace {
  std::string file;
  unsigned line = 0;
  std::string comment;
};
using KeyPlaces = std::map<std::string, KeyPlace>;  ///< by key

/// A tracer option in a file's table [tracer], as written; the tracer's side checks it.
struct TracerText {
  std::string value;
  KeyPlace place;
};
using TracerTexts = std::map<std::string, TracerText>;  ///< by name with _ for -

/// Finds contradictions between the two keys that set the memory clock, dram.mhz and dram.bandwidth_gb_s, layer by
/// layer from the bottom up. A bandwidth may override the dram.mhz of a machine of the project or of an included file,
/// in which the times are written. Every other pair is a contradiction, whatever sources set the two.
class RivalKeys {
 public:
  /// Begins a layer. begun_from: it is a machine of the project, or an included file.
  void begin(bool begun_from);
  /// The layer sets the key, which has its new value.
  void name(const modules::Parameter& key, const KeyPlace& place);
  /// Throws Error{file, place, rule} for a contradiction.
  void require_agreement() const;

 private:
  struct Word {
    unsigned layer = 0;
    bool begun_from = false;
    bool off = false;  ///< the value is 0, which sets nothing
    KeyPlace place;
  };
  static constexpr std::size_t kKeys = 2;
  unsigned layer_ = 0;
  bool begun_from_ = false;
  std::array<Word, kKeys> words_;
};

/// Applies files and settings in order; each overrides those before it. Keys that none of them sets keep their
/// value: a file states differences only. `include = "other.toml"` (path relative to the file, or the name of a
/// machine; a list is read in order) is read first.
class ConfigLayers {
 public:
  explicit ConfigLayers(const std::vector<modules::Parameter>& keys) : keys_(keys) {}

  /// A machine of the project by name, or a file that states differences from `paper`.
  void machine(const std::string& name);
  /// A file, or a machine by name. Throws Error{file, "line N", rule}: syntax, unknown key (with the nearest known
  /// one), wrong type, value out of range, missing or circular include.
  void file(const std::string& path);
  /// Keys of a design, each with its value; origin: "--design walk".
  void design(const std::string& origin, const std::vector<std::pair<std::string, std::string>>& keys);
  /// Each "key=value". Throws Error{"--set", key, rule}.
  void settings(const std::vector<std::string>& all);
  /// Throws Error if the layers contradict each other (RivalKeys).
  void require_agreement() const { rivals_.require_agreement(); }

  const KeyPlaces& places() const { return places_; }
  const TracerTexts& tracer() const { return tracer_; }
  const RivalKeys& rivals() const { return rivals_; }
  /// Every file that was read.
  const std::vector<std::string>& files() const { return files_; }

 private:
  struct Text;
  void read(const std::filesystem::path& path, const std::string& included_from, bool begun_from);
  const Text& text_of(const std::filesystem::path& path);
  void read_includes(const Text& text);
  void read_keys(const Text& text);
  void name(const modules::Parameter& key, const KeyPlace& place);
  void apply(const std::string& setting, const KeyPlace& place);

  const std::vector<modules::Parameter>& keys_;
  KeyPlaces places_;
  TracerTexts tracer_;
  RivalKeys rivals_;
  std::vector<std::string> files_;
  std::map<std::string, std::shared_ptr<const Text>> texts_;  ///< of these files: one that two include is read once
  std::vector<std::filesystem::path> open_;                   ///< files being read, to detect circular includes
};

/// Reads one file into `keys` as ConfigLayers does; tracer options in it are not kept. places: takes the place of every
/// key that is set.
void load_config_file(const std::string& path, const std::vector<modules::Parameter>& keys,
                      KeyPlaces* places = nullptr);

/// "" or why these keys cannot be named together: dram.mhz and dram.bandwidth_gb_s both set the memory clock.
std::string contradiction(bool names_mhz, bool names_bandwidth);

/// Applies "key=value". Throws Error{"--set", key, rule}.
void apply_setting(const std::string& setting, const std::vector<modules::Parameter>& keys);

}  // namespace grtx::sim
