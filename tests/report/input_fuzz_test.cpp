// SPDX-License-Identifier: Apache-2.0
#include "fuzz/input_fuzz.h"

namespace grtx::fuzzing {

INSTANTIATE_TEST_SUITE_P(, InputFuzz, testing::ValuesIn(report_readers()),
                         [](const auto& reader) { return reader.param.name; });

}  // namespace grtx::fuzzing
