// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace waystone {

// A file of the page, as it is stored in the program.
struct WebAsset {
  std::string_view path;  // in the page's folder: "index.html", "app.js"
  std::string_view hash;  // SHA-256 of its plain bytes, in hex
  std::string_view gzip;  // its bytes, compressed by gzip
};

// All files of the page, by path. They live as long as the program. Thread-safe, as all here.
std::span<const WebAsset> WebAssets();

// The plain bytes of an asset.
std::string Unzipped(const WebAsset& asset);

// The media type of a path, by its ending; application/octet-stream where it isn't known.
std::string_view MediaTypeOf(std::string_view path);

}  // namespace waystone
