#include "grtx/frontend/tracer/skips.h"

#include <algorithm>
#include <sstream>

#include "grtx/base/error.h"
#include "grtx/base/nearest_name.h"

namespace grtx::frontend {

const std::vector<std::string>& skip_names() {
  static const std::vector<std::string> names = {"retests", "dead-colours",   "sh-bands", "scene-miss",
                                                 "events",  "never-accepted", "blas"};
  return names;
}

Skips skips_from_text(const std::string& text) {
  if (text == "none") return {};
  if (text == "faithful") return kFaithfulSkips;
  if (text == "all") return kAllSkips;
  Skips skips;
  std::istringstream list(text);
  std::string name;
  do {
    name.clear();
    std::getline(list, name, ',');
    const auto& names = skip_names();
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) {
      std::vector<std::string> known = names;
      known.insert(known.end(), {"none", "faithful", "all"});
      throw Error("--skip", "'" + name + "'", "is unknown; did you mean '" + nearest_name(name, known) + "'?");
    }
    skips.add(static_cast<Skip>(found - names.begin()));
  } while (!list.eof());
  return skips;
}

}  // namespace grtx::frontend
