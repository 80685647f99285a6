// Simulations that a report compares: results.json of `grtx run`, or the statistics of one `grtx sim`.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace grtx::sim {

struct DesignResult {
  std::string name;                   ///< baseline, sw, hw or grtx
  nlohmann::ordered_json statistics;  ///< name -> {value, unit, description}; nothing that depends on the host
  nlohmann::ordered_json inputs;      ///< name -> text
  std::string binding_bound;          ///< "" when not recorded

  /// NaN when there is no such number.
  double value(const std::string& statistic) const;
};

struct RunResults {
  std::string label;  ///< scene and view
  std::string file;   ///< without its folder
  std::string hash;   ///< XXH3 of the file
  std::uint64_t bytes = 0;
  std::string program;
  nlohmann::ordered_json config;
  std::vector<DesignResult> designs;
  nlohmann::ordered_json over_time;       ///< of a single simulation, when recorded
  std::string picture;                    ///< image.png beside results.json; "" when there is none
  std::string speedup_over = "baseline";  ///< name of the design that speed-ups are over
  bool has_verdict = false;               ///< of grtx run: the next two
  bool images_identical = false;
  std::vector<std::string> violations;

  /// nullptr when the run has no such design.
  const DesignResult* design(const std::string& name) const;
};

/// Throws Error when the file is neither grtx.run/1 nor grtx.stats/1, or lacks parts.
RunResults read_run_results(const std::string& path);

/// Name of the design with this structure and checkpointing, e.g. tlas-tri20 and "on": grtx.
std::string design_name(const std::string& accel, const std::string& checkpoint);

}  // namespace grtx::sim
