// SPDX-License-Identifier: Apache-2.0
#include "server/service/web_page.h"

#include <optional>
#include <regex>
#include <string>

#include "server/http/responses.h"
#include "server/web/web_assets.h"

namespace waystone {
namespace {

// Scripts, styles and data only from here; pictures from here, from files that the user chose or
// that were fetched with a token (blob:, which the viewer of panoramas fetches again), and small
// ones in style sheets (data:). Styles that scripts set one by one need no permission.
constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; worker-src 'self'; "
    "connect-src 'self' blob:; img-src 'self' blob: data:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'";

// Whether the client accepts gzip, with a weight other than 0.
bool TakesGzip(const HttpRequest& request) {
  static const std::regex gzip(R"((^|[,\s])gzip\s*(;\s*q=(0\.0*[1-9]|1)[0-9.]*)?\s*(,|$))",
                               std::regex::icase);
  const std::string header = request.header("Accept-Encoding").value_or("");
  constexpr size_t kLongest = 256;  // more than any client sends; a regex takes time
  return header.size() <= kLongest && std::regex_search(header, gzip);
}

HttpResponse Show(const WebAsset& asset, const HttpRequest& request) {
  const bool gzip = TakesGzip(request);
  const std::string etag = "\"" + std::string(asset.hash) + (gzip ? "-gzip\"" : "\"");
  HttpResponse response;
  if (IsKnown(request, etag)) {
    response.status = 304;
  } else {
    response.content_type = MediaTypeOf(asset.path);
    response.body = gzip ? std::string(asset.gzip) : Unzipped(asset);
    if (gzip) response.headers.emplace_back("Content-Encoding", "gzip");
  }
  response.headers.emplace_back("ETag", etag);
  response.headers.emplace_back("Cache-Control", "no-cache");
  response.headers.emplace_back("Vary", "Accept-Encoding");
  response.headers.emplace_back("Content-Security-Policy", kPolicy);
  return response;
}

}  // namespace

void AddWebPage(Router& router) {
  for (const WebAsset& asset : WebAssets()) {
    const auto show = [asset](const HttpRequest& request, const Router::Captures&) {
      return Show(asset, request);
    };
    const bool home = asset.path == "index.html";
    router.Add("GET", home ? "/" : "/page/" + std::string(asset.path), show);
  }
}

}  // namespace waystone
