// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/message.h"

namespace waystone {

// "localhost" or a loopback address; "127.example.org" is neither. Pure; thread-safe.
bool IsLoopback(const std::string& host);

// HOST or HOST:PORT, as in a URL.
struct Authority {
  std::string host;  // lower case; an IPv6 address in its shortest form and without brackets
  std::optional<int> port;

  bool operator==(const Authority&) const = default;
};

// Parses one; nothing for what can't be the authority of a URL. Pure; thread-safe.
std::optional<Authority> ParseAuthority(std::string_view text);

// The names by which clients may address a server. They keep web pages of other sites from sending
// requests to it through their readers' browsers: by a name of theirs that resolves to our address
// (DNS rebinding), or by a POST across sites. Immutable; thread-safe.
class ServerNames {
 public:
  // For a server that listens on `host`, the option --host; `others` are HOST:PORT, or HOST for any
  // port. Throws MapError(kBadOptions) for anything else.
  explicit ServerNames(const std::string& host = "127.0.0.1",
                       const std::vector<std::string>& others = {});

  // Throws MapError: kMisdirected for a Host header that isn't one of
  //   - localhost and the loopback addresses, and `host`, with the server's port or without one;
  //   - `others`;
  //   - where `host` is a wildcard (0.0.0.0, ::), any IP address, to which no name can be rebound,
  //     and localhost, with any port, because port mappings of containers change it.
  // kForeignPage for a POST with an Origin that is none of the names (an address behind a wildcard
  // counts only where Host has it too), or which the browser marks as coming from another site or
  // subdomain (Sec-Fetch-Site). Clients that send neither header (HTTP/1.0, no browser) are
  // admitted.
  void Check(const HttpRequest& request) const;

 private:
  bool IsOurs(const Authority& name, int port) const;
  bool IsReachedBy(const Authority& name, int port) const;
  void CheckOrigin(const HttpRequest& request, const std::string& host) const;

  std::string host_;
  bool is_wildcard_;
  std::vector<Authority> others_;
};

}  // namespace waystone
