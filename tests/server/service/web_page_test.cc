// SPDX-License-Identifier: Apache-2.0
#include "server/service/web_page.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "server/web/web_assets.h"

namespace waystone {
namespace {

class WebPageTest : public testing::Test {
 protected:
  WebPageTest() { AddWebPage(router_); }

  HttpResponse Get(const std::string& path, const std::string& accepted = "",
                   const std::string& known = "") const {
    HttpRequest request;
    request.method = "GET";
    request.path = path;
    request.header = [=](const std::string& name) -> std::optional<std::string> {
      if (name == "Accept-Encoding" && !accepted.empty()) return accepted;
      if (name == "If-None-Match" && !known.empty()) return known;
      return std::nullopt;
    };
    request.read_body = [] { return std::string(); };
    return router_.Dispatch(request);
  }

  static std::string HeaderOf(const HttpResponse& response, const std::string& name) {
    for (const auto& [key, value] : response.headers) {
      if (key == name) return value;
    }
    return "";
  }

  Router router_;
};

TEST_F(WebPageTest, HomeNamesFilesThatAreThere) {
  const HttpResponse home = Get("/");
  EXPECT_EQ(home.status, 200);
  EXPECT_EQ(home.content_type, "text/html; charset=utf-8");
  EXPECT_TRUE(home.body.starts_with("<!doctype html>"));
  for (const char* path : {"/page/main.js", "/page/style.css", "/page/icon.svg"}) {
    EXPECT_NE(home.body.find(path), std::string::npos) << path;
    EXPECT_EQ(Get(path).status, 200) << path;
  }
  EXPECT_EQ(Get("/page/main.js").content_type, "text/javascript; charset=utf-8");
  EXPECT_EQ(Get("/page/nothing.js").status, 404);
  EXPECT_EQ(Get("/page%2Fmain.js").status, 404) << "an encoded slash separates nothing";
}

TEST_F(WebPageTest, CompressedOnlyForWhoTakesIt) {
  const HttpResponse plain = Get("/page/main.js");
  EXPECT_EQ(HeaderOf(plain, "Content-Encoding"), "");
  for (const char* accepted : {"gzip", "gzip, deflate, br", "br;q=1.0, GZIP;q=0.8"}) {
    const HttpResponse response = Get("/page/main.js", accepted);
    EXPECT_EQ(HeaderOf(response, "Content-Encoding"), "gzip") << accepted;
    EXPECT_LT(response.body.size(), plain.body.size());
  }
  for (const char* accepted : {"identity", "br", "gzip;q=0", "gzip;q=0.0, br", "xgzip"}) {
    const HttpResponse response = Get("/page/main.js", accepted);
    EXPECT_EQ(HeaderOf(response, "Content-Encoding"), "") << accepted;
    EXPECT_EQ(response.body, plain.body) << accepted;
  }
}

TEST_F(WebPageTest, KnownBytesAreNotSentAgain) {
  const HttpResponse plain = Get("/");
  const HttpResponse gzip = Get("/", "gzip");
  EXPECT_NE(HeaderOf(plain, "ETag"), HeaderOf(gzip, "ETag")) << "other bytes, other tag";
  const HttpResponse again = Get("/", "gzip", HeaderOf(gzip, "ETag"));
  EXPECT_EQ(again.status, 304);
  EXPECT_TRUE(again.body.empty());
  EXPECT_EQ(Get("/", "", HeaderOf(gzip, "ETag")).status, 200);
  EXPECT_EQ(Get("/", "", "\"other\", W/" + HeaderOf(plain, "ETag")).status, 304);
  EXPECT_EQ(Get("/", "", "*").status, 304) << "any version";
}

TEST_F(WebPageTest, AllowsNothingFromElsewhereAndNothingInline) {
  const std::string policy = HeaderOf(Get("/"), "Content-Security-Policy");
  EXPECT_TRUE(policy.starts_with("default-src 'none'; script-src 'self'; style-src 'self';"));
  EXPECT_EQ(policy.find("unsafe"), std::string::npos);
  EXPECT_EQ(policy.find("http"), std::string::npos);
  const std::string home = Get("/").body;
  EXPECT_EQ(home.find("<style"), std::string::npos);
  EXPECT_EQ(home.find("style="), std::string::npos);
  EXPECT_NE(home.find("<script type=\"module\" src="), std::string::npos);
}

TEST(WebAssets, UnzipToWhatTheirTypesSay) {
  ASSERT_FALSE(WebAssets().empty());
  for (const WebAsset& asset : WebAssets()) {
    EXPECT_NE(MediaTypeOf(asset.path), "application/octet-stream") << asset.path;
    EXPECT_EQ(asset.hash.size(), 64u);
    EXPECT_FALSE(Unzipped(asset).empty()) << asset.path;
  }
}

}  // namespace
}  // namespace waystone
