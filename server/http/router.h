// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "server/http/message.h"

namespace waystone {

// Finds the handler of a request by its path and method, and turns everything that goes wrong on
// the way into a problem. Thread-safe once the routes are added.
class Router {
 public:
  // What stood in the path where the pattern has {name}.
  using Captures = std::map<std::string, std::string>;
  using Handler = std::function<HttpResponse(const HttpRequest&, const Captures&)>;

  // A pattern is a path whose segments may be captures: "/v1/maps/{map}/planes/{id}". A GET route
  // answers HEAD too.
  void Add(const std::string& method, const std::string& pattern, Handler handler);

  // Hears of bugs (what was thrown, for the log); the client hears nothing of them.
  void OnInternalError(std::function<void(const std::string&)> listener);

  // Never throws: the one try and catch around every handler.
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
