#include "grtx/base/printable.h"

namespace grtx {

std::string printable(std::string_view text) {
  std::string shown;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    // UTF-8 has the control characters 0x80 to 0x9f as C2 80 to C2 9f.
    const auto next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : 0);
    const bool of_two = c == 0xc2 && next >= 0x80 && next < 0xa0;
    if (c >= 0x20 && c != 0x7f && !of_two) {
      shown += text[i];
    } else if (c == '\n') {
      shown += "\\n";
    } else {
      const unsigned code = of_two ? next : c;
      shown += {'\\', 'x', "0123456789abcdef"[code >> 4], "0123456789abcdef"[code & 0xf]};
      i += of_two ? 1 : 0;
    }
  }
  return shown;
}

}  // namespace grtx
