// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/observe/vcd_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <string_view>

namespace grtx::sim {
namespace {

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

VcdWriter::Signal VcdWriter::declare(const std::string& name, unsigned width, const Enumeration* enumeration) {
  assert(!begun_ && width >= 1 && width <= 64);
  ids_.push_back(identifier(signals_.size()));
  signals_.push_back({name, width, enumeration});
  values_.push_back(0);
  return signals_.size() - 1;
}

void VcdWriter::append_scopes(std::string& text) const {
  // Signals of one scope must be neighbours: sort by scope, keeping the order of declaration inside one.
  std::vector<const SignalInfo*> order;
  for (const SignalInfo& signal : signals_) order.push_back(&signal);
  const auto scope_of = [](const SignalInfo* signal) {
    auto scope = parts(signal->name);
    scope.pop_back();
    return scope;
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](const SignalInfo* a, const SignalInfo* b) { return scope_of(a) < scope_of(b); });
  std::vector<std::string_view> open;
  const auto close_to = [&](std::size_t depth) {
    for (; open.size() > depth; open.pop_back()) text += "$upscope $end\n";
  };
  for (const SignalInfo* signal : order) {
    const auto scope = scope_of(signal);
    std::size_t common = 0;
    while (common < open.size() && common < scope.size() && open[common] == scope[common]) ++common;
    close_to(common);
    for (; common < scope.size(); ++common) {
      text += fmt::format("$scope module {} $end\n", scope[common]);
      open.push_back(scope[common]);
    }
    const std::string_view leaf = parts(signal->name).back();
    const auto index = static_cast<std::size_t>(signal - signals_.data());
    if (signal->enumeration != nullptr) {
      // Enumeration table in the form that GTKWave's FST tools and wellen (Surfer) read; other viewers skip it.
      const std::vector<std::string>& values = signal->enumeration->values;
      std::string table = fmt::format("{} {}", signal->enumeration->name, values.size());
      for (const std::string& value : values) table += " " + value;
      for (std::size_t i = 0; i < values.size(); ++i) table += fmt::format(" {:0{}b}", i, signal->width);
      text +=
          fmt::format("$attrbegin misc 07 {} {} $end\n$attrbegin misc 07 \"\" {} $end\n", table, index + 1, index + 1);
    }
    const std::string range = signal->width == 1 ? "" : fmt::format(" [{}:0]", signal->width - 1);
    text += fmt::format("$var wire {} {} {}{} $end\n", signal->width, ids_[index], leaf, range);
  }
  close_to(0);
}

void VcdWriter::begin(const std::string& comment, std::uint64_t start_fs) {
  assert(!begun_);
  begun_ = true;
  std::string text =
      fmt::format("$comment\n{}\n$end\n$version grtx {} $end\n$timescale 1 fs $end\n", comment, GRTX_VERSION);
  append_scopes(text);
  text += fmt::format("$enddefinitions $end\n#{}\n$dumpvars\n", start_fs);
  for (Signal signal = 0; signal < signals_.size(); ++signal) append_value(text, signal, values_[signal]);
  text += "$end\n";
  file_.write(text);
  time_ = written_time_ = start_fs;
  changed_ = std::make_unique<BlockWriter<Record>>([this](const std::vector<Record>& block) { write_block(block); });
}

void VcdWriter::append_value(std::string& text, Signal signal, std::uint64_t value) const {
  char line[96];
  char* end = line;
  if (signals_[signal].width == 1) {
    *end++ = (value & 1) != 0 ? '1' : '0';
  } else {
    *end++ = 'b';
    for (int bit = std::max(1, static_cast<int>(std::bit_width(value))); bit-- > 0;) {
      *end++ = static_cast<char>('0' + (value >> bit & 1));
    }
    *end++ = ' ';
  }
  for (const char c : ids_[signal]) *end++ = c;
  *end++ = '\n';
  text.append(line, end);
}

// Runs on the writer thread.
void VcdWriter::write_block(const std::vector<Record>& block) {
  text_.clear();
  for (const Record& record : block) {
    if (record.signal == kTime) {
      text_ += '#' + std::to_string(record.value) + '\n';
    } else {
      append_value(text_, record.signal, record.value);
    }
  }
  file_.write(text_);
}

void VcdWriter::change(Signal signal, std::uint64_t value) {
  assert(signals_[signal].width == 64 || value >> signals_[signal].width == 0);
  values_[signal] = value;
  if (!begun_) return;
  if (time_ != written_time_) {
    assert(time_ > written_time_);
    changed_->push({time_, kTime});
    written_time_ = time_;
  }
  changed_->push({value, signal});
  ++changes_;
}

void VcdWriter::finish(std::uint64_t end_fs) {
  changed_->finish();
  if (end_fs > written_time_) file_.write(fmt::format("#{}\n", end_fs));
  file_.commit();
}

}  // namespace grtx::sim
