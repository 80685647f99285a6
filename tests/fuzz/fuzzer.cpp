// SPDX-License-Identifier: Apache-2.0
// libFuzzer's entry. GRTX_FUZZ_READER names the reader (*_readers.cpp); without it all names are printed.
// GRTX_FUZZ_SEEDS: writes the reader's sound files into that folder, then ends.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "fuzz/readers.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/hash.h"

namespace {

const grtx::fuzzing::InputReader* chosen = nullptr;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  const char* const name = std::getenv("GRTX_FUZZ_READER");
  for (const auto* readers :
       {&grtx::fuzzing::frontend_readers(), &grtx::fuzzing::explore_readers(), &grtx::fuzzing::report_readers()}) {
    for (const auto& reader : *readers) {
      if (name == nullptr) std::puts(reader.name.c_str());
      if (name != nullptr && reader.name == name) chosen = &reader;
    }
  }
  if (chosen == nullptr) std::exit(name == nullptr ? 0 : 2);
  if (const char* const seeds = std::getenv("GRTX_FUZZ_SEEDS")) {
    std::filesystem::create_directories(seeds);
    for (const std::string& seed : chosen->seeds()) {
      if (!grtx::fuzzing::read_bytes(*chosen, seed)) std::exit(2);
      grtx::write_file(std::string(seeds) + "/" + grtx::hex(grtx::xxh3(seed)), seed);
    }
    std::exit(0);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  grtx::fuzzing::read_bytes(*chosen, std::string(reinterpret_cast<const char*>(data), size));
  return 0;
}

extern "C" int sc_main(int, char**) { return 0; }  // libsystemc asks for it
