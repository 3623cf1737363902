// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/base/error.h"
#include "server/http/message.h"

namespace waystone {

// The one place where an error becomes HTTP: an application/problem+json body (RFC 9457) with
// {type, title, status, detail, code}, all but the detail from the table in core/base/error.cc.
HttpResponse ProblemResponse(ErrorCode code, const std::string& detail);

// The same for a status that the HTTP library chose by itself (a request line it can't read).
HttpResponse ProblemResponseForStatus(int status);

}  // namespace waystone
