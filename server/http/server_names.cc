// SPDX-License-Identifier: Apache-2.0
#include "server/http/server_names.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>

#include "core/base/error.h"

namespace waystone {
namespace {

constexpr size_t kMaxHostBytes = 253;  // of a DNS name, RFC 1035

bool IsHostName(std::string_view text) {
  return !text.empty() && text.size() <= kMaxHostBytes &&
         std::all_of(text.begin(), text.end(), [](char c) {
           return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '.' ||
                  c == '_';
         });
}

std::optional<std::string> ShortestIpv6(const std::string& text) {
  in6_addr address{};
  std::array<char, INET6_ADDRSTRLEN> shortest{};
  if (inet_pton(AF_INET6, text.c_str(), &address) != 1) return std::nullopt;
  inet_ntop(AF_INET6, &address, shortest.data(), shortest.size());
  return shortest.data();
}

// In lower case; an IPv6 address in its one normal form.
std::string NormalHost(std::string host) {
  for (char& c : host) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ShortestIpv6(host).value_or(host);
}

bool IsAddress(const std::string& host) {
  in_addr v4{};
  return inet_pton(AF_INET, host.c_str(), &v4) == 1 || ShortestIpv6(host);
}

std::optional<int> ParsePort(std::string_view text) {
  constexpr int kMaxPort = 65535;
  int port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  const bool sound = error == std::errc() && end == text.data() + text.size() && port > 0;
  return sound && port <= kMaxPort ? std::optional(port) : std::nullopt;
}

// That of an Origin header, with its scheme's default port; nothing for "null" and other schemes.
std::optional<Authority> ParseOrigin(std::string_view origin) {
  for (const auto& [scheme, port] : {std::pair("http://", 80), std::pair("https://", 443)}) {
    if (!origin.starts_with(scheme)) continue;
    std::optional<Authority> authority =
        ParseAuthority(origin.substr(std::string_view(scheme).size()));
    if (authority && !authority->port) authority->port = port;
    return authority;
  }
  return std::nullopt;
}

std::string Shown(const std::string& text) {
  constexpr size_t kMost = 80;
  std::string shown = text.substr(0, kMost);
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return "'" + shown + "'";
}

[[noreturn]] void RefusePage(const std::string& page) {
  throw MapError(ErrorCode::kForeignPage,
                 "the request comes from a web page of " + page +
                     ", not of this server; if the server is reached by that name, start it with "
                     "--public-name NAME");
}

}  // namespace

bool IsLoopback(const std::string& host) {
  in_addr v4{};
  if (inet_pton(AF_INET, host.c_str(), &v4) == 1) return (ntohl(v4.s_addr) >> 24) == 127;
  in6_addr v6{};
  if (inet_pton(AF_INET6, host.c_str(), &v6) == 1) return IN6_IS_ADDR_LOOPBACK(&v6);
  return host == "localhost";
}

std::optional<Authority> ParseAuthority(std::string_view text) {
  Authority authority;
  std::string_view rest;
  if (text.starts_with('[')) {
    const size_t end = text.find(']');
    if (end == std::string_view::npos) return std::nullopt;
    const auto address = ShortestIpv6(std::string(text.substr(1, end - 1)));
    if (!address) return std::nullopt;
    authority.host = *address;
    rest = text.substr(end + 1);
  } else {
    const std::string_view host = text.substr(0, text.find(':'));
    if (!IsHostName(host)) return std::nullopt;
    authority.host = NormalHost(std::string(host));
    rest = text.substr(host.size());
  }
  if (rest.empty()) return authority;
  if (!rest.starts_with(':')) return std::nullopt;
  authority.port = ParsePort(rest.substr(1));
  return authority.port ? std::optional(authority) : std::nullopt;
}

ServerNames::ServerNames(const std::string& host, const std::vector<std::string>& others)
    : host_(NormalHost(host)), is_wildcard_(host_.empty() || host_ == "0.0.0.0" || host_ == "::") {
  for (const std::string& text : others) {
    const std::optional<Authority> name = ParseAuthority(text);
    if (!name) {
      throw MapError(ErrorCode::kBadOptions,
                     "--public-name " + Shown(text) +
                         " is not a host name; expected NAME or NAME:PORT, as in maps.example.org");
    }
    others_.push_back(*name);
  }
}

void ServerNames::Check(const HttpRequest& request) const {
  const std::optional<std::string> host = request.header("Host");
  if (host) {
    const std::optional<Authority> name = ParseAuthority(*host);
    if (!name || !IsReachedBy(*name, request.port)) {
      throw MapError(ErrorCode::kMisdirected,
                     "the header Host is " + Shown(*host) +
                         ", which is not a name of this server; use its address, or start it with "
                         "--public-name NAME");
    }
  }
  if (request.method == "POST") CheckOrigin(request, host.value_or(""));
}

bool ServerNames::IsOurs(const Authority& name, int port) const {
  const auto fits = [&](const std::optional<int>& other) {
    return !name.port || !other || *name.port == *other;
  };
  if ((IsLoopback(name.host) || name.host == host_) && fits(port)) return true;
  return std::any_of(others_.begin(), others_.end(), [&](const Authority& other) {
    return name.host == other.host && fits(other.port);
  });
}

bool ServerNames::IsReachedBy(const Authority& name, int port) const {
  if (is_wildcard_ && (IsAddress(name.host) || IsLoopback(name.host))) return true;
  return IsOurs(name, port);
}

void ServerNames::CheckOrigin(const HttpRequest& request, const std::string& host) const {
  const std::string site = request.header("Sec-Fetch-Site").value_or("none");
  if (site != "none" && site != "same-origin") RefusePage("another site");
  const std::optional<std::string> header = request.header("Origin");
  if (!header) return;
  const std::optional<Authority> origin = ParseOrigin(*header);
  if (!origin) RefusePage(Shown(*header));
  std::optional<Authority> own = ParseAuthority(host);
  if (own && !own->port) own->port = header->starts_with("https:") ? 443 : 80;
  if (own != origin && !IsOurs(*origin, request.port)) RefusePage(Shown(*header));
}

}  // namespace waystone
