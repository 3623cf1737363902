// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waystone {

// From now on SIGINT and SIGTERM are only noted, for Interrupted(), so that work can end without
// leaving half a file; the second one ends the program as ever.
void NoteInterrupts();
bool Interrupted();

// From now on SIGINT and SIGTERM end the program at once, with status 130 and a line on stderr: for
// work that writes nothing. NoteInterrupts comes before the writing.
void EndAtInterrupts();

// Holds SIGINT, SIGTERM and SIGHUP back in this thread and all it starts from now on, for
// WaitForSignal.
void BlockSignals();
enum class Awaited { kEnd, kReload, kNothing };
// Sleeps until SIGINT or SIGTERM (kEnd) or SIGHUP (kReload) comes, or the time is over (kNothing).
// Call BlockSignals before starting threads.
Awaited WaitForSignal(double seconds);

}  // namespace waystone
