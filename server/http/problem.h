// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/base/error.h"
#include "server/http/message.h"

namespace waystone {

// Too many requests at once, and when there may be room again.
class BusyError : public MapError {
 public:
  BusyError(const std::string& message, int retry_after_s)
      : MapError(ErrorCode::kBusy, message), retry_after_s_(retry_after_s) {}

  int retry_after_s() const { return retry_after_s_; }

 private:
  int retry_after_s_;
};

// The one place where an error becomes HTTP: an application/problem+json body (RFC 9457) with
// {type, title, status, detail, code}, all but the detail from the table in core/base/error.cc.
// Thread-safe, as all here.
HttpResponse ProblemResponse(ErrorCode code, const std::string& detail);
// The same for an error. Retry-After is a BusyError's own, and 1 s for others that are worth
// another try.
HttpResponse ProblemResponse(const MapError& error);

// For std::bad_alloc.
HttpResponse OutOfMemoryResponse();

// For a method that isn't one of HTTP's: status 501.
HttpResponse UnknownMethodResponse(const std::string& method);

}  // namespace waystone
