// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "server/http/router.h"
#include "server/service/map_source.h"
#include "server/service/query_gate.h"

namespace waystone {

// The contents of the maps over HTTP: summary, planes with features and views, graph, keyframes
// with images, poses, audit, the layers of panoramas and orientations. Lists come in pages. A
// handler finds and renders. Thread-safe.
class MapService {
 public:
  // Both must outlive the service. Audits, the analysis of pictures and smaller copies of them take
  // a turn of the gate.
  MapService(MapSource& maps, QueryGate& gate) : maps_(maps), gate_(gate) {}

  // Adds the routes. The service must outlive the router's last request.
  void AddTo(Router& router);

 private:
  using Captures = Router::Captures;
  using Show = std::function<HttpResponse(const HttpRequest&, const ServedMap&, const Captures&)>;

  void AddShow(Router& router, const std::string& pattern, Show show);
  void AddLists(Router& router);
  void AddSingles(Router& router);
  void AddAppearance(Router& router);
  void AddOrientation(Router& router);
  HttpResponse Home(const HttpRequest& request) const;
  HttpResponse ListMaps(const HttpRequest& request) const;

  MapSource& maps_;
  QueryGate& gate_;
};

}  // namespace waystone
