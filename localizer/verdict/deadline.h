// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/base/clock.h"

namespace waystone {

// When an answer is no use any more; nothing for never.
using Deadline = std::optional<Clock::time_point>;

inline bool HasPassed(const Deadline& deadline) { return deadline && Clock::now() >= *deadline; }

}  // namespace waystone
