// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>

#include "cli/program.h"
#include "cli/system/freed_memory.h"

int main(int argc, char** argv) {
  // FFmpeg comments on each damaged frame of a video, which is reported anyway.
  setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);
  waystone::KeepFreedMemory();
  return waystone::RunProgram(argc, argv);
}
