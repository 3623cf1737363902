// SPDX-License-Identifier: Apache-2.0
#include "server/http/paging.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>

#include "core/base/error.h"
#include "core/base/text.h"

namespace waystone {
namespace {

constexpr uint64_t kDefaultLimit = 100;
constexpr uint64_t kMaxLimit = 1000;
// Cursors are row numbers or ids in disguise, so that nobody relies on their form.
constexpr std::string_view kRowPrefix = "r";
constexpr std::string_view kIdPrefix = "i";
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

// The number of the request's cursor, at most `largest`; nothing without a cursor.
std::optional<uint64_t> CursorOf(const HttpRequest& request, std::string_view prefix,
                                 uint64_t largest) {
  const auto it = request.query.find("cursor");
  if (it == request.query.end()) return std::nullopt;
  const std::string_view cursor = it->second;
  std::optional<uint64_t> number;
  if (cursor.starts_with(prefix)) number = ParseWhole(cursor.substr(prefix.size()), kCursorBase);
  if (!number || *number > largest) {
    throw MapError(ErrorCode::kBadRequest,
                   "invalid cursor for this list; start again without a cursor");
  }
  return number;
}

std::string Cursor(std::string_view prefix, uint64_t number) {
  char digits[sizeof(number) * 2];
  const auto [end, error] = std::to_chars(digits, digits + sizeof(digits), number, kCursorBase);
  return std::string(prefix) + std::string(digits, end);
}

}  // namespace

Page PageOf(const HttpRequest& request, size_t size) {
  Page page;
  const uint64_t limit = Limit(request);
  page.begin = CursorOf(request, kRowPrefix, size).value_or(0);
  page.end = std::min<uint64_t>(size, page.begin + limit);
  if (page.end < size) page.next = Cursor(kRowPrefix, page.end);
  return page;
}

Page PageOf(const HttpRequest& request, const std::vector<int64_t>& ids) {
  Page page;
  const uint64_t limit = Limit(request);
  if (const std::optional<uint64_t> last = CursorOf(request, kIdPrefix, INT64_MAX)) {
    const auto next = std::ranges::upper_bound(ids, static_cast<int64_t>(*last), std::greater<>());
    page.begin = static_cast<size_t>(next - ids.begin());
  }
  page.end = std::min<uint64_t>(ids.size(), page.begin + limit);
  if (page.end < ids.size()) page.next = Cursor(kIdPrefix, ids[page.end - 1]);
  return page;
}

}  // namespace waystone
