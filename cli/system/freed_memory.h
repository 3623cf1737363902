// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waystone {

// From now on the C library keeps freed memory for the next allocation. By default it returns large
// blocks to the kernel at once: the pyramid of each image is then mapped and cleared page by page
// again (docs/benchmarks.md, "Memory between queries"). Applies to the whole process; to be called
// before it has threads. Threads share as many arenas as there are cores, so that what is kept is
// bounded by what that many queries use.
void KeepFreedMemory();

}  // namespace waystone
