// SPDX-License-Identifier: Apache-2.0
// Loaded into the program by LD_PRELOAD: a SIGHUP that comes before main().
#include <csignal>

namespace {

[[gnu::constructor]] void HangUp() { std::raise(SIGHUP); }

}  // namespace
