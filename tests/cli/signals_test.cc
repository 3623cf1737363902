// SPDX-License-Identifier: Apache-2.0
#include "cli/system/signals.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>

namespace waystone {
namespace {

TEST(EndAtInterruptsDeathTest, SaysSoAndEnds) {
  for (const int signal : {SIGINT, SIGTERM}) {
    EXPECT_EXIT(
        {
          EndAtInterrupts();
          raise(signal);
        },
        testing::ExitedWithCode(130), "waystone: interrupted; nothing was written");
  }
}

TEST(EndAtInterruptsDeathTest, AnInterruptWhileWritingIsNoted) {
  EXPECT_EXIT(
      {
        EndAtInterrupts();
        NoteInterrupts();
        raise(SIGTERM);
        _exit(Interrupted() ? 7 : 8);
      },
      testing::ExitedWithCode(7), "");
}

}  // namespace
}  // namespace waystone
