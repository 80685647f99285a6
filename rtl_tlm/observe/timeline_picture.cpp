// SPDX-License-Identifier: Apache-2.0
// A timeline as a picture, SVG: a row per track, each column in the colour of what took most of its cycles. So the file
// stays small, and needs no viewer.
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "grtx/rtl_tlm/observe/trace_event_format.h"

namespace grtx::sim {
namespace {

constexpr std::size_t kColumns = 960;                 ///< at most; their cycles double when the run needs more
constexpr double kLeft = 130.0, kAcross = 960.0;      ///< pixels of the names, and of the cycles
constexpr unsigned kRow = 9, kHead = 20, kFoot = 40;  ///< pixels

class TimelinePicture final : public TraceEventFormat {
 public:
  void head(const Metadata& metadata, std::string&) override {
    for (const auto& [name, value] : metadata) about_ += name + " " + value + "; ";
  }
  void process(unsigned process, const std::string& name, std::string&) override { names_[process] = name; }
  void track(unsigned process, unsigned track, const std::string& name, std::string&) override {
    rows_.resize(track);
    rows_.back() = {names_[process] + " " + name, {}, 0, Columns(kColumns)};
  }
  void begin(unsigned, unsigned track, std::uint64_t cycle, std::string_view name, const Arguments& arguments,
             std::string&) override {
    count(rows_[track - 1], cycle);
    rows_[track - 1].open.push_back(arguments.empty() ? state_of(name) : kNothing);  // a warp and its rounds: no state
  }
  void end(unsigned, unsigned track, std::uint64_t cycle, std::string&) override {
    count(rows_[track - 1], cycle);
    rows_[track - 1].open.pop_back();
  }
  void counter(unsigned, std::uint64_t, std::string_view, const Series&, std::string&) override {}
  void tail(std::string& out) override {
    std::erase_if(rows_, [](const Row& row) { return row.since == 0; });  // warp slots that no warp has had
    const std::size_t height = kHead + rows_.size() * kRow + kFoot;
    out += fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
        "font-family=\"sans-serif\" font-size=\"8\"><desc>{2}</desc><rect width=\"100%\" height=\"100%\" "
        "fill=\"white\"/>\n<text x=\"4\" y=\"12\" font-size=\"10\">cycles {3} to {4}; a column is {5} cycles, in the "
        "colour of what took most of them</text>\n",
        kLeft + kAcross + 10, height, about_, first_, end_, width_);
    const double wide = kAcross * static_cast<double>(width_) / static_cast<double>(std::max<Time>(1, end_ - first_));
    std::vector<std::string> paths(states_.size());
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const std::size_t y = kHead + i * kRow;
      out += fmt::format("<text x=\"4\" y=\"{}\">{}</text>\n", y + kRow - 2, rows_[i].name);
      for (std::size_t column = 0, next = 0; column < kColumns; column = next) {
        const unsigned most = most_of(rows_[i].columns[column]);
        for (next = column + 1; next < kColumns && most_of(rows_[i].columns[next]) == most;) ++next;
        if (most == kNothing) continue;
        paths[most] += fmt::format("M{0:.1f} {1}h{2:.1f}v{3}h-{2:.1f}z", kLeft + static_cast<double>(column) * wide, y,
                                   static_cast<double>(next - column) * wide, kRow - 1);
      }
    }
    for (std::size_t s = 0; s < paths.size(); ++s) {
      const std::size_t x = 130 + 95 * (s % 10), y = height - kFoot + 7 + 12 * (s / 10);
      out += fmt::format("<path fill=\"hsl({}, 60%, {}%)\" d=\"{}M{} {}h8v8h-8z\"/><text x=\"{}\" y=\"{}\">{}</text>\n",
                         s * 137 % 360, s % 2 == 0 ? 45 : 65, paths[s], x, y, x + 11, y + 7, states_[s]);
    }
    out += "</svg>\n";
  }

 private:
  static constexpr unsigned kNothing = ~0u;
  using Time = std::uint64_t;
  using Columns = std::vector<std::map<unsigned, Time>>;  ///< cycles by state
  struct Row {
    std::string name;
    std::vector<unsigned> open;  ///< states of the open slices
    Time since = 0;              ///< counted up to here
    Columns columns;
  };
  unsigned state_of(std::string_view name) {
    const auto found = std::ranges::find(states_, name);
    const auto state = static_cast<unsigned>(found - states_.begin());
    if (found == states_.end()) states_.emplace_back(name);
    return state;
  }
  /// Counts what the row was doing until `cycle`, which is above 0.
  void count(Row& row, Time cycle) {
    if (end_ == 0) first_ = cycle;
    end_ = std::max(end_, cycle);
    while (cycle - first_ > width_ * kColumns) double_width();
    const unsigned state = row.open.empty() ? kNothing : row.open.back();
    for (Time at = row.since, to = 0; state != kNothing && at < cycle; at = to) {
      const Time column = (at - first_) / width_;
      to = std::min(cycle, first_ + (column + 1) * width_);
      row.columns[column][state] += to - at;
    }
    row.since = cycle;
  }
  void double_width() {
    width_ *= 2;
    for (Row& row : rows_) {
      Columns wider(kColumns);
      for (std::size_t i = 0; i < kColumns; ++i) {
        for (const auto& [state, cycles] : row.columns[i]) wider[i / 2][state] += cycles;
      }
      row.columns = std::move(wider);
    }
  }
  /// The state of most cycles of a column; kNothing where most have none.
  unsigned most_of(const std::map<unsigned, Time>& column) const {
    Time most = 0, left = width_;
    unsigned state = kNothing;
    for (const auto& [own, cycles] : column) {
      left -= cycles;
      if (cycles > most) state = own;
      most = std::max(most, cycles);
    }
    return left > most ? kNothing : state;
  }

  std::string about_;
  std::map<unsigned, std::string> names_;  ///< of processes
  std::vector<Row> rows_;
  std::vector<std::string> states_;
  Time first_ = 0, end_ = 0, width_ = 1;
};

}  // namespace

std::unique_ptr<TraceEventFormat> make_timeline_picture() { return std::make_unique<TimelinePicture>(); }

}  // namespace grtx::sim
