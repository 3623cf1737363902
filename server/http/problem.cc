// SPDX-License-Identifier: Apache-2.0
#include "server/http/problem.h"

#include "api/json.h"
#include "api/query_request_json.h"
#include "core/base/text.h"

namespace waystone {
namespace {

constexpr int kRetryS = 1;  // for what is only briefly busy
constexpr int kUnavailable = 503;

// A control character would be a line break or worse wherever the detail is printed.
HttpResponse Problem(ErrorCode code, int status, const std::string& detail,
                     int retry_after_s = kRetryS) {
  const ErrorInfo& info = InfoOf(code);
  Json body;
  body["type"] = "urn:waystone:problem:" + std::string(info.name);
  body["title"] = info.title;
  body["status"] = status;
  body["detail"] = Printable(detail);
  body["code"] = info.name;
  HttpResponse response{status, "application/problem+json", Dump(body), {}};
  if (code == ErrorCode::kBusy || info.http_status == kUnavailable) {
    response.headers.emplace_back("Retry-After", std::to_string(retry_after_s));
  }
  if (code == ErrorCode::kUnauthorized) response.headers.emplace_back("WWW-Authenticate", "Bearer");
  return response;
}

}  // namespace

HttpResponse ProblemResponse(ErrorCode code, const std::string& detail) {
  return Problem(code, InfoOf(code).http_status, detail);
}

HttpResponse ProblemResponse(const MapError& error) {
  const int status = InfoOf(error.code()).http_status;
  const auto* busy = dynamic_cast<const BusyError*>(&error);
  return Problem(error.code(), status, error.what(), busy ? busy->retry_after_s() : kRetryS);
}

HttpResponse OutOfMemoryResponse() {
  return ProblemResponse(ErrorCode::kOutOfMemory,
                         "the server is out of memory; try again or send a smaller image");
}

HttpResponse UnknownMethodResponse(const std::string& method) {
  constexpr int kNotImplemented = 501;
  return Problem(ErrorCode::kMethodNotAllowed, kNotImplemented,
                 QuoteShortened(method) + " is not an HTTP method; methods are in upper case");
}

}  // namespace waystone
