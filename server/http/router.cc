// SPDX-License-Identifier: Apache-2.0
#include "server/http/router.h"

#include <exception>
#include <new>
#include <optional>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "server/http/problem.h"
#include "server/http/request_target.h"

namespace waystone {
namespace {

// RFC 9110, section 9, and PATCH.
bool IsHttpMethod(const std::string& method) {
  static const std::set<std::string> kMethods = {"CONNECT", "DELETE", "GET", "HEAD", "OPTIONS",
                                                 "PATCH",   "POST",   "PUT", "TRACE"};
  return kMethods.contains(method);
}

bool IsCapture(const std::string& segment) { return segment.starts_with('{'); }

std::optional<Router::Captures> CapturesOf(const std::vector<std::string>& pattern,
                                           const std::vector<std::string>& path) {
  if (pattern.size() != path.size()) return std::nullopt;
  Router::Captures captures;
  for (size_t i = 0; i < pattern.size(); ++i) {
    if (IsCapture(pattern[i])) {
      if (path[i].empty()) return std::nullopt;
      captures[pattern[i].substr(1, pattern[i].size() - 2)] = path[i];
    } else if (pattern[i] != path[i]) {
      return std::nullopt;
    }
  }
  return captures;
}

HttpResponse MethodNotAllowed(const HttpRequest& request, const std::set<std::string>& allowed) {
  std::string list;
  for (const std::string& method : allowed) list += (list.empty() ? "" : ", ") + method;
  HttpResponse response = ProblemResponse(
      ErrorCode::kMethodNotAllowed, request.method + " is not allowed for this path; use " + list);
  response.headers.emplace_back("Allow", list);
  return response;
}

}  // namespace

void Router::Add(const std::string& method, const std::string& pattern, Handler handler) {
  routes_.push_back({method, pattern, SegmentsOf(pattern), std::move(handler)});
}

void Router::OnInternalError(std::function<void(const std::string&)> listener) {
  listener_ = std::move(listener);
}

HttpResponse Router::Dispatch(const HttpRequest& request) const {
  if (request.refusal) return ProblemResponse(*request.refusal);
  if (!IsHttpMethod(request.method)) return UnknownMethodResponse(request.method);
  const std::vector<std::string> path = SegmentsOf(request.path);
  const std::string method = request.method == "HEAD" ? "GET" : request.method;
  std::set<std::string> allowed;
  for (const Route& route : routes_) {
    const std::optional<Captures> captures = CapturesOf(route.segments, path);
    if (!captures) continue;
    if (route.method == method) {
      HttpResponse response = Handle(request, route, *captures);
      response.route = route.pattern;
      return response;
    }
    allowed.insert(route.method);
    if (route.method == "GET") allowed.insert("HEAD");
  }
  if (!allowed.empty()) return MethodNotAllowed(request, allowed);
  return ProblemResponse(ErrorCode::kNotFound, "no resource at " + request.path.substr(0, 200));
}

HttpResponse Router::Handle(const HttpRequest& request, const Route& route,
                            const Captures& captures) const {
  try {
    return route.handler(request, captures);
  } catch (const MapError& error) {
    if (error.code() == ErrorCode::kInternal) return InternalError(request, error.what());
    return ProblemResponse(error);
  } catch (const std::bad_alloc&) {
    return OutOfMemoryResponse();
  } catch (const std::exception& error) {
    return InternalError(request, error.what());
  } catch (...) {
    return InternalError(request, "an exception that is not a std::exception");
  }
}

HttpResponse Router::InternalError(const HttpRequest& request, const std::string& cause) const {
  if (listener_) listener_(request.id + " " + request.method + " " + request.path + ": " + cause);
  return ProblemResponse(ErrorCode::kInternal,
                         "an internal error occurred; its cause is in the server's log");
}

}  // namespace waystone
