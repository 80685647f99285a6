// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/regress/regression_case.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <toml++/toml.h>
#include <algorithm>
#include <ctime>
#include <filesystem>
#include <limits>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/nearest_name.h"

namespace grtx::sim {
namespace {

namespace fs = std::filesystem;
constexpr std::string_view kEnding = ".case.toml";

class CaseReader {
 public:
  explicit CaseReader(std::string path) : path_(std::move(path)), folder_(fs::path(path_).parent_path()) {}

  /// One case, or one for each machine of a list.
  std::vector<RegressionCase> read() {
    toml::table table;
    try {
      table = toml::parse(read_file(path_), path_);
    } catch (const toml::parse_error& error) {
      throw Error(path_, fmt::format("line {}", error.source().begin.line), std::string(error.description()));
    }
    case_.file = path_;
    case_.record = (folder_ / "records.tsv").string();
    case_.column = fs::path(path_).filename().string();
    case_.column.resize(case_.column.size() - kEnding.size());
    if (std::any_of(case_.column.begin(), case_.column.end(), [](unsigned char c) { return c < 0x20; })) {
      throw Error(path_, "", "a case's name must have no tab or line break: it heads a column of records.tsv");
    }
    for (const auto& [name, node] : table) read_key(std::string(name.str()), node);
    if (case_.trace.empty()) throw Error(path_, "trace", "is needed: the trace's file");
    if (case_.mode != SimulationMode::windows && windows_key_ != nullptr) {
      fail(*windows_key_, "needs mode = \"windows\"");
    }
    std::vector<RegressionCase> cases;
    for (const std::string& machine : machines_) {
      RegressionCase& own = cases.emplace_back(case_);
      own.machine = machine;
      own.column += "@" + (machine.ends_with(".toml") ? fs::path(machine).stem().string() : machine);
      const auto same = [&](const RegressionCase& other) { return &other != &own && other.column == own.column; };
      if (std::ranges::any_of(cases, same)) throw Error(path_, "machine", "two are called '" + own.column + "'");
    }
    if (cases.empty()) cases.push_back(case_);
    return cases;
  }

 private:
  [[noreturn]] void fail(const toml::node& node, const std::string& rule) const {
    throw Error(path_, line_of(node), rule);
  }
  static std::string line_of(const toml::node& node) { return fmt::format("line {}", node.source().begin.line); }
  std::string text(const toml::node& node, const std::string& name) const {
    const auto* value = node.as_string();
    if (value == nullptr || value->get().empty()) fail(node, name + ": must be a text");
    return value->get();
  }
  std::vector<std::string> texts(const toml::node& node, const std::string& name) const {
    const auto* list = node.as_array();
    if (list == nullptr) fail(node, name + ": must be a list of texts");
    std::vector<std::string> all;
    for (const toml::node& item : *list) all.push_back(text(item, name));
    return all;
  }
  double number(const toml::node& node, const std::string& name, double max) const {
    const auto value = node.is_number() ? node.value<double>() : std::nullopt;
    if (!value || !(*value >= 0.0 && *value <= max))
      fail(node, fmt::format("{}: must be a number, 0 to {}", name, max));
    return *value;
  }
  template <typename Enum>
  Enum choice(const toml::node& node, const std::string& name) const {
    const std::string given = text(node, name);
    const auto known = from_name<Enum>(given);
    if (!known) {
      fail(node,
           fmt::format("{}: unknown '{}', the nearest is '{}'", name, given, nearest_name(given, names_of<Enum>())));
    }
    return *known;
  }
  /// Relative to the case's folder.
  std::string path(const toml::node& node, const std::string& name) const {
    return (folder_ / text(node, name)).lexically_normal().string();
  }

  std::string machine(const toml::node& node, const std::string& name) const {
    const std::string given = text(node, name);
    return given.ends_with(".toml") ? path(node, name) : given;
  }

  void read_key(const std::string& name, const toml::node& node) {
    if (name == "trace") {
      case_.trace = path(node, name);
    } else if (name == "machine" && node.is_array()) {
      if (node.as_array()->empty()) fail(node, "machine: the list is empty");
      for (const toml::node& item : *node.as_array()) machines_.push_back(machine(item, name));
    } else if (name == "machine") {
      case_.machine = machine(node, name);
    } else if (name == "config") {
      case_.config = path(node, name);
    } else if (name == "design") {
      case_.design = text(node, name);
    } else if (name == "set") {
      case_.settings = texts(node, name);
      for (const toml::node& item : *node.as_array()) {
        case_.setting_places.push_back({text(item, name), line_of(item)});
      }
    } else if (name == "mode") {
      if (const std::string gone = gone_mode(text(node, name)); !gone.empty()) fail(node, gone);
      case_.mode = choice<SimulationMode>(node, name);
    } else if (name == "statistics") {
      case_.statistics = texts(node, name);
      if (case_.statistics.empty()) fail(node, "statistics: the list is empty");
    } else if (name == "tolerance") {
      read_tolerances(node);
    } else if (name != "update" && name != "title" && !read_windows(name, node)) {  // the first two are for people
      fail(node, fmt::format("unknown key '{}', the nearest is '{}'", name,
                             nearest_name(name, {"trace", "machine", "config", "design", "set", "mode", "share", "seed",
                                                 "statistics", "tolerance", "title", "update"})));
    }
  }

  /// False if the key does not belong to windows mode.
  bool read_windows(const std::string& name, const toml::node& node) {
    if (name == "share") {
      case_.windows.share = number(node, name, 1.0);
      if (case_.windows.share == 0.0) fail(node, "share: must be above 0");
    } else if (name == "seed") {
      const auto* seed = node.as_integer();
      if (seed == nullptr || seed->get() < 0) fail(node, "seed: must be an integer, 0 or more");
      case_.windows.seed = static_cast<std::uint64_t>(seed->get());
    } else {
      return false;
    }
    windows_key_ = &node;
    return true;
  }

  void read_tolerances(const toml::node& node) {
    const auto* table = node.as_table();
    if (table == nullptr) fail(node, "tolerance: must be a table: \"pattern\" = share");
    std::vector<std::pair<toml::source_position, RegressionTolerance>> all;
    for (const auto& [pattern, value] : *table) {
      const std::string name(pattern.str());
      if (value.is_table()) fail(value, fmt::format("tolerance: a pattern is a text: \"{}...\"", name));
      all.push_back({value.source().begin, {name, number(value, "tolerance: " + name, 1e6), line_of(value)}});
    }
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
      return std::pair(a.first.line, a.first.column) < std::pair(b.first.line, b.first.column);
    });
    for (auto& [position, tolerance] : all) case_.tolerances.push_back(std::move(tolerance));
  }

  std::string path_;
  fs::path folder_;
  RegressionCase case_;
  std::vector<std::string> machines_;  ///< of a list
  const toml::node* windows_key_ = nullptr;
};

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  return fmt::format("{:04}-{:02}-{:02}", utc.tm_year + 1900, utc.tm_mon + 1, utc.tm_mday);
}

/// The text as a TOML string on one line.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
  }
  return out + "\"";
}

}  // namespace

std::vector<RegressionCase> load_regression(const std::string& folder) {
  if (!fs::is_directory(folder)) throw Error(folder, "", "is no folder");
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().filename().string().ends_with(kEnding)) files.push_back(entry.path());
  }
  if (files.empty()) throw Error(folder, "", fmt::format("holds no case (NAME{})", kEnding));
  std::sort(files.begin(), files.end());
  std::vector<RegressionCase> cases;
  for (const fs::path& file : files) {
    for (RegressionCase& own : CaseReader(file.string()).read()) {
      const std::string below = file.parent_path().lexically_relative(folder).generic_string();
      own.name = (below == "." || below.empty() ? "" : below + "/") + own.column;
      cases.push_back(std::move(own));
    }
  }
  return cases;
}

bool matches_pattern(const std::string& pattern, const std::string& name) {
  return ::fnmatch(pattern.c_str(), name.c_str(), 0) == 0;
}

bool is_compared(const RegressionCase& regression_case, const std::string& statistic) {
  return !statistic.starts_with("host.") &&
         std::any_of(regression_case.statistics.begin(), regression_case.statistics.end(),
                     [&](const std::string& pattern) { return matches_pattern(pattern, statistic); });
}

double tolerance_of(const RegressionCase& regression_case, const std::string& statistic) {
  double relative = 0.0;
  for (const RegressionTolerance& tolerance : regression_case.tolerances) {
    if (matches_pattern(tolerance.pattern, statistic)) relative = tolerance.relative;
  }
  return relative;
}

void note_update(const RegressionCase& regression_case, const std::string& program, const std::string& reason) {
  std::string text = read_file(regression_case.file);
  if (!text.empty() && text.back() != '\n') text += '\n';
  const std::string update =
      fmt::format("\n[[update]]\ndate = {}\nprogram = {}\nreason = {}\n", today(), quoted(program), quoted(reason));
  if (!text.ends_with(update)) write_file(regression_case.file, text + update);  // of another machine of its list
}

}  // namespace grtx::sim
