// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waystone {

// Raises the process's limit on open files, as far as the system allows, so that `wanted`
// connections fit beside the program's other files. Returns how many connections there may be, at
// most `wanted`. Throws MapError(kBadOptions) where fewer than 16 are left, and fewer than wanted.
// Internal to server/http. To be called by one thread at a time.
int RaiseFileLimit(int wanted);

}  // namespace waystone
