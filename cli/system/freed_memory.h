// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waystone {

// From now on the C library keeps freed memory for the next allocation. By default it gives large
// blocks back to the kernel at once: the pyramid of an image is then mapped and cleared page by
// page for each image again (docs/benchmarks.md, "Memory between queries"). For the whole
// process, before it has threads. Threads share as many arenas as there are cores, so that what is
// kept is bounded by what so many queries use.
void KeepFreedMemory();

}  // namespace waystone
