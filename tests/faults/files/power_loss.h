// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "tests/faults/files/file_calls.h"

namespace waystone {

// What a folder's files hold, by their names.
using DiskState = std::map<std::filesystem::path, std::string>;

// A state in which a loss of power after `calls` may leave a folder that was `before`. Each file
// holds what it held when it was last synced and some of what was written to it since: any of these
// writes, whole or in part, in any order. Of the creations and renames since the folder was last
// synced, the first ones happened, up to any. `random` chooses.
DiskState StateAfterPowerLoss(const DiskState& before, std::span<const FileCall> calls,
                              Random& random);

}  // namespace waystone
