// SPDX-License-Identifier: Apache-2.0
#include "server/service/home_page.h"

#include "core/base/text.h"

namespace waystone {
namespace {

constexpr const char* kHomeHead = R"(<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>Waystone</title>
<style>
body { font: 16px/1.5 system-ui, sans-serif; max-width: 46rem; margin: 3rem auto; padding: 0 1rem; }
pre { background: #f2f3f5; color: #14171a; padding: .8rem 1rem; overflow-x: auto; border-radius: 6px; }
@media (prefers-color-scheme: dark) { body { background: #14171a; color: #e8eaed; } a { color: #8ab4f8; }
pre { background: #23272b; color: #e8eaed; } }
</style>
<h1>Waystone</h1>
<p>Localize photos in the maps of this server.</p>
)";

std::string Link(const std::string& address, const std::string& text) {
  return "<a href=\"" + EscapeHtml(address) + "\">" + EscapeHtml(text) + "</a>";
}

}  // namespace

std::string HomePage(const std::vector<std::string>& map_names, const std::string& host) {
  std::string page = kHomeHead;
  for (const std::string& name : map_names) {
    const std::string base = "/v1/maps/" + EncodeSegment(name);
    page += "<h2>" + EscapeHtml(name) + "</h2>\n<pre>" +
            EscapeHtml("curl --data-binary @photo.jpg -H 'Content-Type: image/jpeg' http://" +
                       host + base + "/localize") +
            "</pre>\n<p>" + Link(base, "summary");
    for (const char* part : {"planes", "graph", "keyframes"}) {
      page += " · " + Link(base + "/" + part, part);
    }
    page += "</p>\n";
  }
  return page + "</html>\n";
}

}  // namespace waystone
