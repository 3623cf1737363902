// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waystone {

// The whole program: parses the command line, runs the subcommand, and turns errors into one line
// on stderr and an exit code: 0 success, 2 usage, 3 invalid input or output, a refusing server or
// out of memory, 4 no usable result, 5 internal, 6 registry or store out of reach, 130 interrupted.
// Never throws. Not thread-safe.
int RunProgram(int argc, char** argv);

}  // namespace waystone
