// SPDX-License-Identifier: Apache-2.0
#include "cli/program.h"
#include "cli/system/freed_memory.h"

int main(int argc, char** argv) {
  waystone::KeepFreedMemory();
  return waystone::RunProgram(argc, argv);
}
