// SPDX-License-Identifier: Apache-2.0
// The server's small parts: problems, paging, routes, the gate, the home page.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "api/json.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "server/http/home_page.h"
#include "server/http/paging.h"
#include "server/http/problem.h"
#include "server/http/query_gate.h"
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

TEST(Problem, OddStatusKeepsItself) {
  EXPECT_EQ(ProblemResponseForStatus(414).status, 414);
  EXPECT_EQ(ProblemResponseForStatus(503).status, 503);
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

TEST_F(RouterTest, BugsAreLoggedAndNotSent) {
  const HttpResponse response = router_.Dispatch(Request("POST", "/a/x/c"));
  EXPECT_EQ(response.status, 500);
  EXPECT_EQ(response.body.find("secret"), std::string::npos);
  EXPECT_NE(log_.find("secret detail"), std::string::npos);
}

TEST(QueryGate, LetsInAsManyAsItMayAndTurnsTheRestAway) {
  QueryGate gate(1, 1);
  std::atomic<bool> second_in = false;
  std::thread second;
  {
    const QueryGate::Turn first = gate.Enter();
    second = std::thread([&] {
      const QueryGate::Turn turn = gate.Enter();
      second_in = true;
    });
    // The second one sits in the queue's only seat before long; from then on it is full.
    bool busy = false;
    for (int i = 0; i < 2000 && !busy; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      if (i < 20) continue;
      try {
        const QueryGate::Turn third = gate.Enter();
      } catch (const MapError& error) {
        busy = error.code() == ErrorCode::kBusy;
      }
    }
    EXPECT_TRUE(busy);
    EXPECT_FALSE(second_in);
  }
  second.join();
  EXPECT_TRUE(second_in);
  const QueryGate::Turn again = gate.Enter();
}

TEST(QueryGate, SaysWhenThereMayBeRoom) {
  QueryGate gate(1, 0);
  const auto retry_after_s = [&] {
    try {
      const QueryGate::Turn turn = gate.Enter();
    } catch (const BusyError& busy) {
      return busy.retry_after_s();
    }
    return 0;
  };
  {
    const QueryGate::Turn turn = gate.Enter();
    EXPECT_EQ(retry_after_s(), 1) << "no turn has ended yet";
    std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  }
  const QueryGate::Turn turn = gate.Enter();
  EXPECT_EQ(retry_after_s(), 2) << "a turn took over a second";
}

TEST(QueryGate, NeverMoreThanItsNumberInside) {
  QueryGate gate(2, 100);
  std::atomic<int> inside = 0;
  std::atomic<int> most = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < 8; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < 50; ++i) {
        const QueryGate::Turn turn = gate.Enter();
        const int now = ++inside;
        int seen = most;
        while (now > seen && !most.compare_exchange_weak(seen, now)) {
        }
        std::this_thread::yield();
        --inside;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_LE(most, 2);
  EXPECT_GE(most, 1);
}

TEST(HomePage, EscapesNames) {
  const std::string page = HomePage({"<b>&\"x"}, "h<o>st");
  EXPECT_EQ(page.find("<b>&"), std::string::npos);
  EXPECT_EQ(page.find("h<o>st"), std::string::npos);
  EXPECT_NE(page.find("/v1/maps/%3Cb%3E%26%22x/localize"), std::string::npos);
}

}  // namespace
}  // namespace waystone
