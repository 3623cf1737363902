// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/base/clock.h"

namespace waystone {

// The time after which an answer is useless; nothing for never. HasPassed is thread-safe.
using Deadline = std::optional<Clock::time_point>;

inline bool HasPassed(const Deadline& deadline) { return deadline && Clock::now() >= *deadline; }

}  // namespace waystone
