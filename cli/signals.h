// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waystone {

// From now on SIGINT and SIGTERM are only noted, for Interrupted(), so that work can end without
// leaving half a file; the second one ends the program as ever.
void NoteInterrupts();
bool Interrupted();

// Holds SIGINT and SIGTERM back in this thread and all it starts from now on, for WaitForInterrupt.
void BlockInterrupts();
// Sleeps until SIGINT or SIGTERM comes. Call BlockInterrupts before starting threads.
void WaitForInterrupt();

}  // namespace waystone
