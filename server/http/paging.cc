// SPDX-License-Identifier: Apache-2.0
#include "server/http/paging.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string_view>

#include "core/base/error.h"
#include "core/base/text.h"

namespace waystone {
namespace {

constexpr uint64_t kDefaultLimit = 100;
constexpr uint64_t kMaxLimit = 1000;
// Cursors are row numbers in disguise, so that nobody relies on their form.
constexpr std::string_view kCursorPrefix = "r";
constexpr int kCursorBase = 16;

std::optional<uint64_t> ParseWhole(std::string_view text, int base) {
  uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc() || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return value;
}

uint64_t Limit(const HttpRequest& request) {
  const auto it = request.query.find("limit");
  if (it == request.query.end()) return kDefaultLimit;
  const std::optional<uint64_t> limit = ParseWhole(it->second, 10);
  if (!limit || *limit < 1 || *limit > kMaxLimit) {
    throw MapError(ErrorCode::kBadRequest, "limit '" + Printable(it->second.substr(0, 40)) +
                                               "' is invalid; it must be between 1 and " +
                                               std::to_string(kMaxLimit));
  }
  return *limit;
}

size_t FirstRow(const HttpRequest& request, size_t size) {
  const auto it = request.query.find("cursor");
  if (it == request.query.end()) return 0;
  const std::string_view cursor = it->second;
  std::optional<uint64_t> row;
  if (cursor.starts_with(kCursorPrefix)) {
    row = ParseWhole(cursor.substr(kCursorPrefix.size()), kCursorBase);
  }
  if (!row || *row > size) {
    throw MapError(ErrorCode::kBadRequest,
                   "invalid cursor for this list; start again without a cursor");
  }
  return *row;
}

std::string CursorTo(size_t row) {
  char digits[sizeof(row) * 2];
  const auto [end, error] = std::to_chars(digits, digits + sizeof(digits), row, kCursorBase);
  return std::string(kCursorPrefix) + std::string(digits, end);
}

}  // namespace

Page PageOf(const HttpRequest& request, size_t size) {
  Page page;
  const uint64_t limit = Limit(request);
  page.begin = FirstRow(request, size);
  page.end = std::min<uint64_t>(size, page.begin + limit);
  if (page.end < size) page.next = CursorTo(page.end);
  return page;
}

}  // namespace waystone
