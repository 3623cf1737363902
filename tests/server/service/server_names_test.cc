// SPDX-License-Identifier: Apache-2.0
// Web pages of somebody else, which make their reader's browser ask a server that only the reader
// reaches: by DNS rebinding, and by posts across sites.
#include "server/http/server_names.h"

#include <gtest/gtest.h>

#include <map>

#include "core/base/error.h"
#include "server/service/application.h"
#include "tests/server/service/made_map.h"

namespace waystone {
namespace {

constexpr int kPort = 8080;

using Headers = std::map<std::string, std::string>;

HttpRequest RequestOf(const std::string& method, const Headers& headers) {
  HttpRequest request;
  request.method = method;
  request.path = "/v1/maps";
  request.port = kPort;
  request.header = [headers](const std::string& name) -> std::optional<std::string> {
    const auto it = headers.find(name);
    return it == headers.end() ? std::nullopt : std::optional(it->second);
  };
  request.read_body = [] { return std::string("x"); };
  return request;
}

// 200, or the status of the error.
int StatusOf(const ServerNames& names, const std::string& method, const Headers& headers) {
  try {
    names.Check(RequestOf(method, headers));
  } catch (const MapError& error) {
    return InfoOf(error.code()).http_status;
  }
  return 200;
}

int StatusOfHost(const ServerNames& names, const std::string& host) {
  return StatusOf(names, "GET", {{"Host", host}});
}

TEST(ServerNames, ReboundNamesAreRefused) {
  const ServerNames names;
  for (const char* host : {"localhost:8080", "LOCALHOST:8080", "localhost", "127.0.0.1:8080",
                           "127.1.2.3:8080", "[::1]:8080", "[0:0::0:1]:8080"}) {
    EXPECT_EQ(StatusOfHost(names, host), 200) << host;
  }
  for (const char* host : {"evil.example:8080",
                           "evil.example",
                           "localhost.evil.example:8080",
                           "127.0.0.1.evil.example",
                           "localhost:8081",
                           "127.0.0.1:80",
                           "192.168.1.5:8080",
                           "0.0.0.0:8080",
                           "[::2]:8080",
                           "",
                           "localhost:",
                           "localhost:x",
                           "localhost:8080:8080",
                           "localhost:99999",
                           "[::1",
                           "[localhost]",
                           "a@localhost:8080",
                           "localhost:8080/",
                           "localhost:8080, evil.example",
                           "127.0.0.1 evil"}) {
    EXPECT_EQ(StatusOfHost(names, host), 421) << host;
  }
  EXPECT_EQ(StatusOf(names, "GET", {}), 200) << "HTTP/1.0, which no browser speaks";
}

TEST(ServerNames, PublicNamesAreAdmitted) {
  const ServerNames names("192.168.1.5", {"maps.example.org", "localhost:9000", "[FD00:0::1]"});
  for (const char* host : {"192.168.1.5:8080", "maps.example.org", "Maps.Example.org:443",
                           "localhost:9000", "localhost:8080", "[fd00::1]:1"}) {
    EXPECT_EQ(StatusOfHost(names, host), 200) << host;
  }
  for (const char* host : {"192.168.1.6:8080", "org", "example.org", "localhost:9001"}) {
    EXPECT_EQ(StatusOfHost(names, host), 421) << host;
  }
  for (const char* wrong : {"", "https://maps.example.org", "maps.example.org/", "a b", "maps:0"}) {
    EXPECT_THROW(ServerNames("127.0.0.1", {wrong}), MapError) << wrong;
  }
}

TEST(ServerNames, WildcardsAdmitAddressesButNoNames) {
  for (const char* wildcard : {"0.0.0.0", "::", ""}) {
    const ServerNames names(wildcard);
    for (const char* host : {"10.0.0.7:8080", "10.0.0.7:32768", "[fd00::7]:8080", "localhost:9000",
                             "127.0.0.1", "0.0.0.0:8080"}) {
      EXPECT_EQ(StatusOfHost(names, host), 200) << wildcard << " " << host;
    }
    for (const char* host :
         {"evil.example:8080", "robot:8080", "10.0.0.7.evil.example", "0x7f.1"}) {
      EXPECT_EQ(StatusOfHost(names, host), 421) << wildcard << " " << host;
    }
  }
}

TEST(ServerNames, PostsOfOtherSitesAreRefused) {
  const ServerNames names("127.0.0.1", {"maps.example.org"});
  const auto post = [&](Headers headers) {
    headers.emplace("Host", "localhost:8080");
    return StatusOf(names, "POST", headers);
  };
  EXPECT_EQ(post({}), 200) << "no browser";
  for (const char* origin : {"http://localhost:8080", "http://127.0.0.1:8080", "http://[::1]:8080",
                             "https://maps.example.org"}) {
    EXPECT_EQ(post({{"Origin", origin}}), 200) << origin;
    EXPECT_EQ(post({{"Origin", origin}, {"Sec-Fetch-Site", "same-origin"}}), 200) << origin;
  }
  for (const char* origin : {"http://evil.example", "null", "", "http://localhost:3000",
                             "http://localhost", "https://localhost", "file://localhost:8080",
                             "http://maps.example.org.evil.example", "localhost:8080"}) {
    EXPECT_EQ(post({{"Origin", origin}}), 403) << origin;
  }
  for (const char* site : {"cross-site", "same-site", "else"}) {
    EXPECT_EQ(post({{"Sec-Fetch-Site", site}}), 403) << site;
  }
  // A link to the page is followed from anywhere.
  EXPECT_EQ(StatusOf(names, "GET", {{"Host", "localhost:8080"}, {"Sec-Fetch-Site", "cross-site"}}),
            200);
}

TEST(ServerNames, BehindAWildcardPagesPostToTheirOwnAddress) {
  const ServerNames names("0.0.0.0");
  const auto post = [&](const char* host, const char* origin) {
    return StatusOf(names, "POST", {{"Host", host}, {"Origin", origin}});
  };
  EXPECT_EQ(post("10.0.0.7:8080", "http://10.0.0.7:8080"), 200);
  EXPECT_EQ(post("localhost:9000", "http://localhost:9000"), 200) << "a container's port mapping";
  EXPECT_EQ(post("10.0.0.7", "http://10.0.0.7"), 200);
  EXPECT_EQ(post("10.0.0.7:8080", "http://10.0.0.8:8080"), 403);
  EXPECT_EQ(post("10.0.0.7:8080", "http://10.0.0.7"), 403);
}

TEST(ServerNames, TheApplicationAsksAndHealthChecksPass) {
  Application app(MapCatalog::Indices{{"lab", MapIndex::Build(MadeMap(3))}}, {}, {});
  HttpRequest request = RequestOf("GET", {{"Host", "evil.example:8080"}});
  for (const auto& [path, status] : std::map<std::string, int>{{"/", 421},
                                                               {"/page/main.js", 421},
                                                               {"/v1/maps", 421},
                                                               {"/nowhere", 421},
                                                               {"/healthz", 200},
                                                               {"/readyz", 200}}) {
    request.path = path;
    EXPECT_EQ(app.Answer(request).status, status) << path;
  }
  HttpRequest post =
      RequestOf("POST", {{"Host", "localhost:8080"}, {"Origin", "http://evil.example"}});
  post.path = "/v1/localize";
  const HttpResponse refused = app.Answer(post);
  EXPECT_EQ(refused.status, 403);
  EXPECT_NE(refused.body.find("--public-name"), std::string::npos) << refused.body;
  EXPECT_NE(refused.body.find(R"("code":"foreign_page")"), std::string::npos) << refused.body;
}

}  // namespace
}  // namespace waystone
