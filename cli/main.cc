// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <string_view>

#include "cli/program.h"

// Sanitizers aren't ready so early.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
namespace {

// SIGHUP tells a server to reload its maps; one that comes while the server starts must wait, not
// end it. The initialisers of the libraries alone take a tenth of a second, so it is held back
// before they run. BlockSignals() takes over.
void HoldHangups(int argc, char** argv, char** /*environment*/) {
  if (argc < 2 || std::string_view(argv[1]) != "serve") return;
  sigset_t hangups;
  sigemptyset(&hangups);
  sigaddset(&hangups, SIGHUP);
  sigprocmask(SIG_BLOCK, &hangups, nullptr);
}

[[gnu::section(".preinit_array"), gnu::used]] void (*const hold_hangups)(int, char**,
                                                                         char**) = HoldHangups;

}  // namespace
#endif

int main(int argc, char** argv) { return waystone::RunProgram(argc, argv); }
