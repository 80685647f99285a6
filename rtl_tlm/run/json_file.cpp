#include "grtx/rtl_tlm/run/json_file.h"

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"

namespace grtx::sim {

nlohmann::ordered_json parse_json(const std::string& text, const std::string& file) {
  try {
    return nlohmann::ordered_json::parse(text);
  } catch (const nlohmann::json::parse_error& error) {
    throw Error(file, "byte " + std::to_string(error.byte), "is not valid JSON");
  } catch (const nlohmann::json::out_of_range&) {
    throw Error(file, "", "is not readable JSON: holds a number that no double can hold");
  }
}

nlohmann::ordered_json read_json(const std::string& path) { return parse_json(read_file(path), path); }

}  // namespace grtx::sim
