// SPDX-License-Identifier: Apache-2.0
// HTTP's small parts: problems, paging, routes.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "api/json.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "server/http/file_limit.h"
#include "server/http/paging.h"
#include "server/http/problem.h"
#include "server/http/request_target.h"
#include "server/http/router.h"

namespace waystone {
namespace {

HttpRequest Request(const std::string& method, const std::string& path) {
  HttpRequest request;
  request.method = method;
  request.path = path;
  request.header = [](const std::string&) { return std::nullopt; };
  request.read_body = [] { return std::string(); };
  return request;
}

std::string HeaderOf(const HttpResponse& response, const std::string& name) {
  for (const auto& [key, value] : response.headers) {
    if (key == name) return value;
  }
  return "";
}

TEST(Problem, HasTheFieldsOfRfc9457AndTheTablesRow) {
  const HttpResponse response = ProblemResponse(ErrorCode::kPayloadTooLarge, "21 MB");
  EXPECT_EQ(response.status, 413);
  EXPECT_EQ(response.content_type, "application/problem+json");
  EXPECT_EQ(response.body,
            R"({"type":"urn:waystone:problem:payload_too_large","title":"Request body too large",)"
            R"("status":413,"detail":"21 MB","code":"payload_too_large"})");
}

TEST(Problem, BusySaysWhenToComeBack) {
  EXPECT_EQ(HeaderOf(ProblemResponse(ErrorCode::kBusy, "full"), "Retry-After"), "1");
  EXPECT_EQ(HeaderOf(ProblemResponse(BusyError("full", 7)), "Retry-After"), "7");
  EXPECT_EQ(HeaderOf(ProblemResponse(MapError(ErrorCode::kNotFound, "x")), "Retry-After"), "");
}

TEST(Problem, ControlCharactersAreShown) {
  const std::string detail = std::string("a\0b\n", 4);
  EXPECT_EQ(Json::parse(ProblemResponse(ErrorCode::kNotFound, detail).body)["detail"],
            "a\\u0000b\\u000a");
}

// In a process of its own, because a limit can't be raised again.
TEST(FileLimit, SaysWhereLittleIsLeft) {
  const auto raise = [](rlim_t files, int wanted) {
    const rlimit limit = {files, files};
    setrlimit(RLIMIT_NOFILE, &limit);
    try {
      std::fprintf(stderr, "%d connections", RaiseFileLimit(wanted));
    } catch (const MapError& error) {
      std::fprintf(stderr, "%s", error.what());
    }
    std::_Exit(0);
  };
  const testing::ExitedWithCode good(0);
  EXPECT_EXIT(
      raise(100, 1024), good,
      "the limit of open files is 100, which leaves 0 of 1024 connections; raise it to 1124");
  EXPECT_EXIT(raise(100, 1), good, "leaves 0 of 1 ");
  EXPECT_EXIT(raise(110, 1024), good, "leaves 10 of 1024");
  EXPECT_EXIT(raise(110, 10), good, "^10 connections");
  EXPECT_EXIT(raise(200, 1024), good, "^100 connections");
}

TEST(RequestTarget, IsDecoded) {
  EXPECT_EQ(PathOf("/%61%20b+c/%7e?x=1"), "/a b+c/~");
  EXPECT_EQ(PathOf("/a%00b#f?x"), std::string("/a\0b", 4));
  const std::map<std::string, std::string> expected = {
      {"name", "a=b.jpg"}, {"fov deg", "6 3+"}, {"flag", ""}, {"s", "1;t=2?u"}};
  EXPECT_EQ(QueryOf("/p?name=a=b.jpg&&fov%20deg=6+3%2B&flag&s=1;t=2?u&"), expected);
  EXPECT_TRUE(QueryOf("/p").empty());
  EXPECT_TRUE(QueryOf("/p?").empty());
}

// RFC 3986, sections 2.2 and 2.4: an encoded slash separates nothing.
TEST(RequestTarget, SegmentsAreSplitBeforeTheyAreDecoded) {
  EXPECT_EQ(PathOf("/a%2fb%2F/c"), "/a%2Fb%2F/c");
  EXPECT_EQ(PathOf("/%252F%zz%4"), "/%252F%25zz%254");
  using Segments = std::vector<std::string>;
  const auto segments = [](const char* target) { return SegmentsOf(PathOf(target)); };
  EXPECT_EQ(segments("/a%2Fb/c%20d?/x"), (Segments{"a/b", "c d"}));
  EXPECT_EQ(segments("/%252F/%zz%4/%%34%31"), (Segments{"%2F", "%zz%4", "%41"}));
  EXPECT_EQ(segments("/a//%2e%2e/"), (Segments{"a", "", "..", ""}));
  EXPECT_EQ(segments("/a%00b"), (Segments{std::string("a\0b", 3)}));
  EXPECT_EQ(segments("/"), Segments());
}

TEST(RequestTarget, RepeatedAndNamelessFieldsAreRefused) {
  const auto refusal = [](const std::string& target) -> std::string {
    try {
      QueryOf(target);
    } catch (const MapError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal("/p?fov_deg=63&top_k=1&fov_deg=abc"),
            "the URL has the field 'fov_deg' more than once; give it once");
  EXPECT_NE(refusal("/p?a=1&a=1"), "");
  EXPECT_NE(refusal("/p?%61&a"), "");
  EXPECT_EQ(refusal("/p?=1"), "the URL has a value without a name, '=1'; fields are NAME=VALUE");
}

TEST(Paging, PagesJoinToTheWholeList) {
  HttpRequest request = Request("GET", "/");
  request.query["limit"] = "4";
  std::vector<size_t> rows;
  int pages = 0;
  for (std::string next = "first"; !next.empty(); ++pages) {
    if (next != "first") request.query["cursor"] = next;
    const Page page = PageOf(request, 10);
    for (size_t i = page.begin; i < page.end; ++i) rows.push_back(i);
    next = page.next;
    ASSERT_LT(pages, 5);
  }
  EXPECT_EQ(pages, 3);
  EXPECT_EQ(rows, (std::vector<size_t>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}));
}

TEST(Paging, EmptyListIsOnePage) {
  const Page page = PageOf(Request("GET", "/"), 0);
  EXPECT_EQ(page.end, 0u);
  EXPECT_EQ(page.next, "");
}

// Jobs that are enqueued between two pages come before the first one.
TEST(Paging, RowsInFrontOfAListByIdsRepeatNone) {
  HttpRequest request = Request("GET", "/");
  request.query["limit"] = "2";
  const Page first = PageOf(request, std::vector<int64_t>{30, 20, 10});
  EXPECT_EQ(first.begin, 0u);
  EXPECT_EQ(first.end, 2u);
  request.query["cursor"] = first.next;
  const Page second = PageOf(request, std::vector<int64_t>{50, 40, 30, 20, 10});
  EXPECT_EQ(second.begin, 4u);
  EXPECT_EQ(second.end, 5u);
  EXPECT_EQ(second.next, "");
  EXPECT_EQ(PageOf(request, std::vector<int64_t>{50, 10}).begin, 1u) << "20 is gone";
  EXPECT_EQ(PageOf(request, std::vector<int64_t>{}).begin, 0u);
  for (const char* cursor : {"", "i", "14", "r1", "izz", "i-1", "iffffffffffffffff"}) {
    request.query["cursor"] = cursor;
    EXPECT_THROW(PageOf(request, std::vector<int64_t>{30}), MapError) << cursor;
  }
}

TEST(Paging, NonsenseIsABadRequest) {
  for (const char* limit : {"0", "-1", "1001", "x", "", "5 ", "99999999999999999999"}) {
    HttpRequest request = Request("GET", "/");
    request.query["limit"] = limit;
    EXPECT_THROW(PageOf(request, 10), MapError) << limit;
  }
  for (const char* cursor : {"", "r", "5", "rzz", "rb", "r-1", "rffffffffffffffffff"}) {
    HttpRequest request = Request("GET", "/");
    request.query["cursor"] = cursor;
    EXPECT_THROW(PageOf(request, 10), MapError) << cursor;
  }
}

class RouterTest : public testing::Test {
 protected:
  RouterTest() {
    router_.Add("GET", "/a/{x}/b", [](const auto&, const Router::Captures& in) {
      return HttpResponse{200, "text/plain", in.at("x"), {}};
    });
    router_.Add("POST", "/a/{x}/c", [](const auto&, const auto&) -> HttpResponse {
      throw std::runtime_error("secret detail");
    });
    router_.Add("GET", "/", [](const auto&, const auto&) { return HttpResponse(); });
    router_.OnInternalError([this](const std::string& cause) { log_ += cause; });
  }
  Router router_;
  std::string log_;
};

TEST_F(RouterTest, CapturesSegments) {
  EXPECT_EQ(router_.Dispatch(Request("GET", "/a/kitchen/b")).body, "kitchen");
  EXPECT_EQ(router_.Dispatch(Request("GET", "/a/x%2Fb/b")).body, "x/b");
  EXPECT_EQ(router_.Dispatch(Request("GET", "/a/x%2Fb")).status, 404);
  EXPECT_EQ(router_.Dispatch(Request("HEAD", "/a/kitchen/b")).status, 200);
  EXPECT_EQ(router_.Dispatch(Request("GET", "/")).status, 200);
}

TEST_F(RouterTest, WhatIsNotThereIsNotFound) {
  for (const char* path : {"/a", "/a/b", "/a//b", "/a/x/b/", "/a/x/d", "//", "", "x"}) {
    const int expected = std::string(path).size() == 0 || std::string(path) == "x" ? 200 : 404;
    EXPECT_EQ(router_.Dispatch(Request("GET", path)).status, expected) << path;
  }
}

TEST_F(RouterTest, WrongMethodNamesTheRightOnes) {
  const HttpResponse response = router_.Dispatch(Request("POST", "/a/x/b"));
  EXPECT_EQ(response.status, 405);
  EXPECT_EQ(HeaderOf(response, "Allow"), "GET, HEAD");
  EXPECT_EQ(HeaderOf(router_.Dispatch(Request("DELETE", "/a/x/c")), "Allow"), "POST");
}

TEST_F(RouterTest, UnknownMethodsAreNotImplemented) {
  for (const char* method : {"FOO", "get", ""}) {
    EXPECT_EQ(router_.Dispatch(Request(method, "/a/x/b")).status, 501) << method;
  }
}

TEST_F(RouterTest, WhatCannotBeReadIsRefusedWithItsCause) {
  HttpRequest request = Request("GET", "/a/x/b");
  request.refusal.emplace(ErrorCode::kTooSlow, "late");
  EXPECT_EQ(router_.Dispatch(request).status, 408);
}

TEST_F(RouterTest, BugsAreLoggedAndNotSent) {
  const HttpResponse response = router_.Dispatch(Request("POST", "/a/x/c"));
  EXPECT_EQ(response.status, 500);
  EXPECT_EQ(response.body.find("secret"), std::string::npos);
  EXPECT_NE(log_.find("secret detail"), std::string::npos);
}

}  // namespace
}  // namespace waystone
