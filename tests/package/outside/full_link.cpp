// SPDX-License-Identifier: Apache-2.0
// A user's release build, in which asserts are gone: a link says what is wrong all the same.
#include <cstdio>
#include <cstring>
#include <systemc>

#include "grtx/modules/kernel/link.h"

#ifndef NDEBUG
#error "this is about a build without asserts"
#endif

int sc_main(int, char*[]) {
  grtx::modules::Link<int> link("link", 1, 2);
  try {
    for (int i = 0; i < 5; ++i) link.push(0, i);
  } catch (const sc_core::sc_report& report) {
    std::puts(report.get_msg());
    return std::strcmp(report.get_msg(), "link: push() into a full link");
  }
  return 1;
}
