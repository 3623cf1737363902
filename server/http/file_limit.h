// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waystone {

// Raises the limit on open files so that there may be `wanted` connections besides the program's
// other files, as far as the system lets it. How many connections there may be. Throws
// MapError(kBadOptions) where few are left. Inside server/http only.
int RaiseFileLimit(int wanted);

}  // namespace waystone
