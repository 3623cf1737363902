// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "server/http/message.h"

namespace waystone {

// Finds the handler of a request by its path and method, and turns whatever goes wrong into a
// problem response. Thread-safe once the routes are added.
class Router {
 public:
  // What the path has where the pattern has {name}, decoded: it may contain slashes.
  using Captures = std::map<std::string, std::string>;
  using Handler = std::function<HttpResponse(const HttpRequest&, const Captures&)>;

  // A pattern is a path whose segments may be captures: "/v1/maps/{map}/planes/{id}". A GET route
  // answers HEAD too.
  void Add(const std::string& method, const std::string& pattern, Handler handler);

  // `listener` is told of bugs (what was thrown, for the log); the client isn't.
  void OnInternalError(std::function<void(const std::string&)> listener);

  // The one try and catch around every handler. Throws nothing but std::bad_alloc.
  HttpResponse Dispatch(const HttpRequest& request) const;

 private:
  struct Route {
    std::string method;
    std::string pattern;
    std::vector<std::string> segments;
    Handler handler;
  };

  HttpResponse Handle(const HttpRequest& request, const Route& route,
                      const Captures& captures) const;
  HttpResponse InternalError(const HttpRequest& request, const std::string& cause) const;

  std::vector<Route> routes_;
  std::function<void(const std::string&)> listener_;
};

}  // namespace waystone
