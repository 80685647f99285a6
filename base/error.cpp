#include "grtx/base/error.h"

namespace grtx {
namespace {

std::string one_line(const std::string& file, const std::string& place, const std::string& rule) {
  std::string text = file;
  if (!place.empty()) text += (text.empty() ? "" : ": ") + place;
  if (!rule.empty()) text += (text.empty() ? "" : ": ") + rule;
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';  // input quoted in a message must not break the line
  }
  return text;
}

}  // namespace

Error::Error(std::string file, std::string place, std::string rule)
    : std::runtime_error(one_line(file, place, rule)),
      file_(std::move(file)),
      place_(std::move(place)),
      rule_(std::move(rule)) {}

}  // namespace grtx
