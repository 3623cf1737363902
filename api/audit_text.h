// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "api/json.h"
#include "quality/audit.h"

namespace waystone {

// An audit as text for people, with what to do about each finding, and as JSON for programs. Both
// are thread-safe.
std::string AuditText(const MapIndex& index, const AuditReport& report);
Json AuditJson(const MapIndex& index, const AuditReport& report);

}  // namespace waystone
