// SPDX-License-Identifier: Apache-2.0
#include "server/web/web_assets.h"

#include <zlib.h>

#include <array>
#include <utility>

#include "core/base/check.h"

namespace waystone {
namespace {

constexpr int kGzipWindow =
    15 + 16;  // zlib's largest window, with gzip's header instead of its own
constexpr size_t kChunkBytes = 64 * 1024;

}  // namespace

std::string Unzipped(const WebAsset& asset) {
  z_stream stream{};
  WS_CHECK(inflateInit2(&stream, kGzipWindow) == Z_OK, "zlib doesn't start");
  // zlib only reads the input, but says so only where ZLIB_CONST is defined.
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(asset.gzip.data()));
  stream.avail_in = static_cast<uInt>(asset.gzip.size());
  std::string plain;
  std::string chunk(kChunkBytes, '\0');
  int state = Z_OK;
  while (state == Z_OK) {
    stream.next_out = reinterpret_cast<Bytef*>(chunk.data());
    stream.avail_out = static_cast<uInt>(chunk.size());
    state = inflate(&stream, Z_NO_FLUSH);
    plain.append(chunk.data(), chunk.size() - stream.avail_out);
  }
  inflateEnd(&stream);
  WS_CHECK(state == Z_STREAM_END, "the page's files in the program are damaged");
  return plain;
}

std::string_view MediaTypeOf(std::string_view path) {
  using Entry = std::pair<std::string_view, std::string_view>;
  static constexpr std::array<Entry, 6> kTypes = {{
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".svg", "image/svg+xml"},
      {".txt", "text/plain; charset=utf-8"},
      {".json", "application/json"},
  }};
  for (const auto& [ending, type] : kTypes) {
    if (path.ends_with(ending)) return type;
  }
  return "application/octet-stream";
}

}  // namespace waystone
