// The `grtx` program (program.h): what must be so before it begins.
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <new>
#include <systemc>

#include "grtx/apps/grtx/program.h"

/// Libraries ask for memory before main, some of them as they are loaded: what is here is called before that.
[[gnu::used, gnu::section(".preinit_array")]] void (*const kBeforeLibraries)() = [] {
  std::set_new_handler(grtx::end_without_memory);
};

int sc_main(int argc, char** argv) { return grtx::program(argc, argv, grtx::kMachinesFolder); }

/// A file that is opened gets the lowest free descriptor. Were that 0, 1 or 2, what is printed would go into the file.
void secure_standard_streams() {
  for (int descriptor = 0; descriptor <= 2; ++descriptor) {
    if (::fcntl(descriptor, F_GETFD) == -1 && errno == EBADF)
      ::open("/dev/null", descriptor == 0 ? O_RDONLY : O_WRONLY);
  }
}

int main(int argc, char** argv) {
  secure_standard_streams();
  if (setenv("SYSTEMC_DISABLE_COPYRIGHT_MESSAGE", "1", 1) != 0)
    grtx::end_without_memory();  // SystemC reads it before sc_main
  return sc_core::sc_elab_and_sim(argc, argv);
}
