// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waystone {

// The whole program: parses the command line, runs the subcommand, and turns what goes wrong into
// one line on stderr and an exit code: 0 ok, 2 usage, 3 bad input, 4 finished below the quality
// gate, 5 internal, 130 interrupted. Never throws.
int RunProgram(int argc, char** argv);

}  // namespace waystone
