// SPDX-License-Identifier: Apache-2.0
// Entry point of the `grtx` program (program.h): sets up out-of-memory handling, standard streams and SystemC.
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <new>
#include <systemc>

#include "grtx/apps/grtx/program.h"

/// Installs the out-of-memory handler before library initialisers run, since they already allocate memory.
[[gnu::used, gnu::section(".preinit_array")]] void (*const kBeforeLibraries)() = [] {
  std::set_new_handler(grtx::end_without_memory);
};

int sc_main(int argc, char** argv) { return grtx::program(argc, argv, grtx::kMachinesFolder); }

/// Opens a device for closed standard streams: else the next file opened would get descriptor 0, 1 or 2, and output
/// would be written into it. Standard output then cannot be written, so that a command whose results are lost says so;
/// a line for stderr may go nowhere.
void secure_standard_streams() {
  for (int descriptor = 0; descriptor <= 2; ++descriptor) {
    if (::fcntl(descriptor, F_GETFD) != -1 || errno != EBADF) continue;
    if (descriptor == 1 && ::open("/dev/full", O_WRONLY) == 1) continue;
    ::open("/dev/null", descriptor == 2 ? O_WRONLY : O_RDONLY);
  }
}

int main(int argc, char** argv) {
  secure_standard_streams();
  return sc_core::sc_elab_and_sim(argc, argv);
}
