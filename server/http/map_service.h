// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <string>

#include "localizer/localizer.h"
#include "localizer/map_index.h"
#include "localizer/options.h"
#include "server/http/query_gate.h"
#include "server/http/router.h"

namespace waystone {

struct ServiceOptions {
  LocalizeOptions localize;
  // Queries computed at once; 0 takes as many as there are cores. More don't answer faster, they
  // only answer later together.
  int query_threads = 0;
  // Queries that wait for their turn; the next ones get 429. A longer queue turns fewer away and
  // keeps the last ones waiting longer.
  int queue_length = 32;

  void Check() const;  // throws MapError(kBadOptions)
};

// The maps over HTTP: what each path means. A handler parses, calls and renders; what to compute is
// the localizer's. Thread-safe: the maps are immutable.
class MapService {
 public:
  using Maps = std::map<std::string, std::shared_ptr<const MapIndex>>;  // by name

  MapService(Maps maps, const ServiceOptions& options);

  // Adds the routes. The service must outlive the router's last request.
  void AddTo(Router& router);

 private:
  using Captures = Router::Captures;

  const MapIndex& MapOf(const Captures& captures) const;  // throws MapError(kNotFound)

  HttpResponse Home(const HttpRequest& request) const;
  HttpResponse ListMaps(const HttpRequest& request) const;
  HttpResponse ShowMap(const Captures& captures) const;
  HttpResponse ListPlanes(const HttpRequest& request, const Captures& captures) const;
  HttpResponse ShowPlane(const Captures& captures) const;
  HttpResponse ShowGraph(const Captures& captures) const;
  HttpResponse ListKeyframes(const HttpRequest& request, const Captures& captures) const;
  HttpResponse ShowKeyframe(const Captures& captures) const;
  HttpResponse ShowImage(const Captures& captures) const;
  HttpResponse Localize(const HttpRequest& request, const Captures& captures);

  Maps maps_;
  ServiceOptions options_;
  QueryGate gate_;
};

}  // namespace waystone
