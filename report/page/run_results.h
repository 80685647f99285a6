// SPDX-License-Identifier: Apache-2.0
// Simulation results for a report: results.json of `grtx run`, or the statistics of one `grtx sim`.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "grtx/report/page/subject.h"
#include "grtx/rtl_tlm/run/result_notes.h"

namespace grtx::report {

/// Confidence interval of an estimate.
struct Interval {
  double low = 0.0, high = 0.0;
};
/// Conservative interval of the ratio over / of: the values may be correlated in any way.
std::optional<Interval> ratio_of(const std::optional<Interval>& over, const std::optional<Interval>& of);
/// Interval of gpu.cycles if it was estimated, else nullopt. value(name): returns a statistic, NaN if missing.
template <typename Value>
std::optional<Interval> cycles_interval(Value&& value) {
  const Interval interval{value("gpu.windows.cycles_low"), value("gpu.windows.cycles_high")};
  if (!(interval.low < interval.high)) return std::nullopt;  // also if everything was simulated
  return interval;
}

/// How a design's pictures differ from others, by frame, in dB; infinite where they are identical.
struct PictureResult {
  std::string order;              ///< by which its hits are blended
  bool fp64 = true;               ///< against the fp64 reference; else against the tracer at full precision
  double pixels = 0.0;            ///< of a frame that were compared with it
  std::vector<double> over;       ///< against the design that speed-ups are over
  std::vector<double> reference;  ///< against the reference in the design's own order
};

/// Frames of a simulation, by its statistics (name -> {value, ...}); 1, but of a sequence.
std::size_t frames_of(const nlohmann::ordered_json& statistics);
/// "the frame", or of a sequence "a frame, mean of 8": whose time or energy a figure is.
std::string frame_text(std::size_t frames);

struct DesignResult {
  std::string name;                   ///< as design_name()
  nlohmann::ordered_json statistics;  ///< name -> {value, unit, description}; without host.*
  nlohmann::ordered_json inputs;      ///< name -> text
  nlohmann::ordered_json config;      ///< resolved, with the design's own keys
  Subject subject;
  std::string binding_bound;             ///< "" when not recorded
  sim::ResultNotes notes;                ///< limitations of its results
  std::optional<PictureResult> picture;  ///< not of a single simulation, nor of older runs
  std::vector<double> frame_speedups;    ///< of a sequence
  nlohmann::ordered_json over_time;      ///< name -> {values, unit, description} by interval; null if not recorded

  /// Value of a statistic; NaN if there is no such number.
  double value(const std::string& statistic) const;
  std::optional<Interval> cycles_interval() const;
  /// Frames whose sums its statistics are: 1, but of a sequence.
  std::size_t frames() const { return frames_of(statistics); }
  /// Time of a frame in s, of a sequence the mean; NaN if not recorded.
  double frame_seconds() const;
};

struct RunResults {
  std::string label;  ///< one-line description of scene, k of each design, machine and mode
  Subject subject;    ///< of its first design
  std::string file;   ///< without its folder
  std::string hash;   ///< XXH3 of the file
  std::uint64_t bytes = 0;
  std::string program;
  nlohmann::ordered_json config;  ///< without keys that a design brings, if it is of grtx run
  std::vector<DesignResult> designs;
  std::string picture;                    ///< path of the picture named in results.json; "" if there is none
  std::string picture_problem;            ///< why that picture is not shown
  std::string speedup_over = "baseline";  ///< design that speed-ups are relative to
  bool has_verdict = false;               ///< result of grtx run; the next two members are valid
  bool images_identical = false;
  std::vector<std::string> violations;
  std::map<std::string, std::string> left_out;        ///< designs that refused an option, and why
  std::map<std::string, Interval> speedup_intervals;  ///< by design; computed by grtx run from paired samples

  /// The design of this name; nullptr if the run has none.
  const DesignResult* design(const std::string& name) const;
  /// Interval of a design's speed-up over `speedup_over`; nullopt if both are exact.
  std::optional<Interval> speedup_interval(const DesignResult& design) const;
};

/// Describes the run in one line by its first design, with the k of those that have another.
std::string label_of(const RunResults& run);

/// One for each machine. Throws Error if the file is neither grtx.run/2 or /1 nor grtx.stats/1, or is incomplete.
std::vector<RunResults> read_run_results(const std::string& path);

}  // namespace grtx::report
