// Simulations that a report compares: results.json of `grtx run`, or the statistics of one `grtx sim`.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "grtx/rtl_tlm/run/result_notes.h"
#include "grtx/view/report/subject.h"

namespace grtx::sim {

/// In which the true value is meant to lie, with the confidence that the estimate names.
struct Interval {
  double low = 0.0, high = 0.0;
};
/// That of a ratio of two values, whatever they have in common.
std::optional<Interval> ratio_of(const std::optional<Interval>& over, const std::optional<Interval>& of);
/// Of gpu.cycles, of an estimate from a sample. value(name): of a statistic, NaN when there is none.
template <typename Value>
std::optional<Interval> cycles_interval(Value&& value) {
  const Interval interval{value("gpu.sampled.cycles_low"), value("gpu.sampled.cycles_high")};
  if (!(interval.low < interval.high)) return std::nullopt;  // also of what was simulated as a whole
  return interval;
}

struct DesignResult {
  std::string name;                   ///< baseline, sw, hw or grtx
  nlohmann::ordered_json statistics;  ///< name -> {value, unit, description}; nothing that depends on the host
  nlohmann::ordered_json inputs;      ///< name -> text
  std::string binding_bound;          ///< "" when not recorded
  ResultNotes notes;                  ///< what limits the meaning of its figures

  /// NaN when there is no such number.
  double value(const std::string& statistic) const;
  std::optional<Interval> cycles_interval() const;
};

struct RunResults {
  std::string label;  ///< what it is of, in a line
  Subject subject;    ///< of all its designs
  std::string file;   ///< without its folder
  std::string hash;   ///< XXH3 of the file
  std::uint64_t bytes = 0;
  std::string program;
  nlohmann::ordered_json config;
  std::vector<DesignResult> designs;
  nlohmann::ordered_json over_time;       ///< of a single simulation, when recorded
  std::string picture;                    ///< path of the picture that results.json names; "" when there is none
  std::string picture_problem;            ///< why the picture that it names is not shown
  std::string speedup_over = "baseline";  ///< name of the design that speed-ups are over
  bool has_verdict = false;               ///< of grtx run: the next two
  bool images_identical = false;
  std::vector<std::string> violations;
  std::map<std::string, Interval> speedup_intervals;  ///< by design, as grtx run knows them of paired samples

  /// nullptr when the run has no such design.
  const DesignResult* design(const std::string& name) const;
  /// Of a design over `speedup_over`; nothing where both are exact.
  std::optional<Interval> speedup_interval(const DesignResult& design) const;
};

/// Throws Error when the file is neither grtx.run/1 nor grtx.stats/1, or lacks parts.
RunResults read_run_results(const std::string& path);

/// Name of the design with this structure and checkpointing, e.g. tlas-tri20 and "on": grtx.
std::string design_name(const std::string& accel, const std::string& checkpoint);

}  // namespace grtx::sim
