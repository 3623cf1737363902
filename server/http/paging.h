// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "api/json.h"
#include "server/http/message.h"

namespace waystone {

// The part of a list that a request asks for: ?limit=N (1 to 1000, 100 by default) and
// ?cursor=... as the `next` of the page before gave it.
struct Page {
  size_t begin = 0;  // first row
  size_t end = 0;    // one past the last row
  std::string next;  // the cursor of the page after; empty at the end
};

// The rows to give of a list of `size` rows. Throws MapError(kBadRequest) for an invalid limit or
// cursor. Thread-safe.
Page PageOf(const HttpRequest& request, size_t size);

// The same for a list that grows at its front between pages: `ids` are those of its rows, falling.
// A cursor names the last row given instead of counting rows, so that no row is given twice.
Page PageOf(const HttpRequest& request, const std::vector<int64_t>& ids);

// {name: [the page's rows, as `render` makes row i of them], "next": cursor or null}.
template <class Render>
Json PagedJson(const Page& page, const std::string& name, const Render& render) {
  Json json;
  json[name] = Json::array();
  for (size_t i = page.begin; i < page.end; ++i) json[name].push_back(render(i));
  json["next"] = page.next.empty() ? Json(nullptr) : Json(page.next);
  return json;
}
template <class Render>
Json PagedJson(const HttpRequest& request, const std::string& name, size_t size,
               const Render& render) {
  return PagedJson(PageOf(request, size), name, render);
}

}  // namespace waystone
