#include "rtl_tlm/vcd_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <string_view>

namespace grtx::tlm {
namespace {

constexpr std::size_t kFlushBytes = 1 << 20;

/// Short identifier made of the printable characters that the format allows.
std::string identifier(std::size_t number) {
  constexpr std::size_t kFirst = '!', kCount = '~' - '!' + 1;
  std::string id;
  do {
    id += static_cast<char>(kFirst + number % kCount);
    number /= kCount;
  } while (number-- != 0);
  return id;
}

std::vector<std::string_view> parts(std::string_view name) {
  std::vector<std::string_view> result;
  for (;;) {
    const std::size_t dot = name.find('.');
    result.push_back(name.substr(0, dot));
    if (dot == std::string_view::npos) return result;
    name.remove_prefix(dot + 1);
  }
}

}  // namespace

VcdWriter::Signal VcdWriter::declare(const std::string& name, unsigned width,
                                     const std::vector<std::string>& enumeration) {
  assert(!begun_ && width >= 1 && width <= 64);
  signals_.push_back({name, width, enumeration, identifier(signals_.size()), 0});
  return signals_.size() - 1;
}

void VcdWriter::write_scopes() {
  // Signals of one scope must be neighbours: sort by scope, keeping the order of declaration inside one.
  std::vector<const Declared*> order;
  for (const Declared& signal : signals_) order.push_back(&signal);
  const auto scope_of = [](const Declared* signal) {
    auto scope = parts(signal->name);
    scope.pop_back();
    return scope;
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](const Declared* a, const Declared* b) { return scope_of(a) < scope_of(b); });
  std::vector<std::string_view> open;
  const auto close_to = [&](std::size_t depth) {
    for (; open.size() > depth; open.pop_back()) buffer_ += "$upscope $end\n";
  };
  for (const Declared* signal : order) {
    const auto scope = scope_of(signal);
    std::size_t common = 0;
    while (common < open.size() && common < scope.size() && open[common] == scope[common]) ++common;
    close_to(common);
    for (; common < scope.size(); ++common) {
      buffer_ += fmt::format("$scope module {} $end\n", scope[common]);
      open.push_back(scope[common]);
    }
    const std::string_view leaf = parts(signal->name).back();
    if (!signal->enumeration.empty()) {
      // Enumeration table in the form that GTKWave's FST tools and wellen (Surfer) read; other viewers skip it.
      std::string table = fmt::format("{}_values {}", leaf, signal->enumeration.size());
      for (const std::string& value : signal->enumeration) table += " " + value;
      for (std::size_t i = 0; i < signal->enumeration.size(); ++i) table += fmt::format(" {:0{}b}", i, signal->width);
      buffer_ += fmt::format("$attrbegin misc 07 {} {} $end\n$attrbegin misc 07 \"\" {} $end\n", table,
                             signal - signals_.data() + 1, signal - signals_.data() + 1);
    }
    const std::string range = signal->width == 1 ? "" : fmt::format(" [{}:0]", signal->width - 1);
    buffer_ += fmt::format("$var wire {} {} {}{} $end\n", signal->width, signal->id, leaf, range);
  }
  close_to(0);
}

void VcdWriter::begin(const std::string& comment, std::uint64_t start_fs) {
  assert(!begun_);
  begun_ = true;
  buffer_ += fmt::format("$comment\n{}\n$end\n$version grtx {} $end\n$timescale 1 fs $end\n", comment, GRTX_VERSION);
  write_scopes();
  buffer_ += fmt::format("$enddefinitions $end\n#{}\n$dumpvars\n", start_fs);
  for (const Declared& signal : signals_) write_value(signal);
  buffer_ += "$end\n";
  time_ = written_time_ = start_fs;
}

void VcdWriter::write_value(const Declared& signal) {
  if (signal.width == 1) {
    buffer_ += (signal.value & 1) != 0 ? '1' : '0';
  } else {
    buffer_ += 'b';
    for (int bit = std::max(1, static_cast<int>(std::bit_width(signal.value))); bit-- > 0;) {
      buffer_ += (signal.value >> bit & 1) != 0 ? '1' : '0';
    }
    buffer_ += ' ';
  }
  buffer_ += signal.id;
  buffer_ += '\n';
}

void VcdWriter::flush() {
  file_.write(buffer_);
  buffer_.clear();
}

void VcdWriter::change(Signal signal, std::uint64_t value) {
  Declared& changed = signals_[signal];
  assert(changed.width == 64 || value >> changed.width == 0);
  changed.value = value;
  if (!begun_) return;
  if (time_ != written_time_) {
    assert(time_ > written_time_);
    buffer_ += '#' + std::to_string(time_) + '\n';
    written_time_ = time_;
  }
  write_value(changed);
  if (buffer_.size() > kFlushBytes) flush();
}

void VcdWriter::finish(std::uint64_t end_fs) {
  if (end_fs > written_time_) buffer_ += fmt::format("#{}\n", end_fs);
  flush();
  file_.commit();
}

}  // namespace grtx::tlm
