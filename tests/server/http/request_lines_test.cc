// SPDX-License-Identifier: Apache-2.0
// The first line of a request, from the socket to the handler.
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>

#include "server/http/http_server.h"
#include "server/http/responses.h"
#include "server/http/router.h"
#include "tests/server/http/raw_client.h"

namespace waystone {
namespace {

class RequestLines : public testing::Test {
 protected:
  RequestLines() {
    router_.Add("GET", "/hello", [](const auto&, const auto&) {
      return HttpResponse{200, "text/plain", "hello", {}};
    });
    HttpOptions options;
    options.port = 0;
    server_ = std::make_unique<HttpServer>(
        options, [this](const HttpRequest& in) { return router_.Dispatch(in); });
    server_->Start();
  }

  std::string Exchange(const std::string& bytes) const {
    RawClient client(server_->port());
    client.Send(bytes);
    return client.Receive();
  }

  Router router_;
  std::unique_ptr<HttpServer> server_;
};

TEST_F(RequestLines, MalformedRequestLinesCloseTheConnection) {
  for (const char* line : {"GET /hel lo HTTP/1.1", "GET * HTTP/1.1", "GET hello HTTP/1.1",
                           "G@T /hello HTTP/1.1", "GET /hello HTTP/1.2"}) {
    const auto start = std::chrono::steady_clock::now();
    const std::string text = Exchange(std::string(line) + "\r\nHost: x\r\n\r\n");
    EXPECT_NE(text.find(" 400 "), std::string::npos) << line << '\n' << text;
    EXPECT_NE(text.find("Connection: close"), std::string::npos) << text;
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(WAYSTONE_SLOWDOWN))
        << line;
  }
}

TEST_F(RequestLines, UnknownMethodsAreAnsweredLikeOthers) {
  RawClient client(server_->port());
  for (const char* method : {"FOO", "get"}) {
    client.Send(std::string(method) + " /hello HTTP/1.1\r\nHost: x\r\n\r\n");
    const std::string text = client.Receive("}");
    EXPECT_NE(text.find(" 501 "), std::string::npos) << text;
    EXPECT_NE(text.find(method), std::string::npos) << text;
  }
  client.Send("FOO /hello HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
  EXPECT_NE(client.Receive().find("Connection: close"), std::string::npos);
}

TEST_F(RequestLines, TheRequestIsReadAsItWasSent) {
  router_.Add("GET", "/echo", [](const HttpRequest& in, const auto&) {
    std::string text = in.header("host").value_or("none") + " " + in.path;
    for (const auto& [name, value] : in.query) text += " " + name + "=" + value;
    return HttpResponse{200, "text/plain", text, {}};
  });
  const auto body = [this](const std::string& target, const std::string& host) {
    const std::string text =
        Exchange("GET " + target + " HTTP/1.1\r\nHost:" + host + "\r\nConnection: close\r\n\r\n");
    return text.substr(text.find("\r\n\r\n") + 4);
  };
  EXPECT_EQ(body("/%65cho?a=b=c&d=e+f", " x"), "x /echo a=b=c d=e f");
  EXPECT_EQ(body("http://y:7/echo?a=1", " x"), "y:7 /echo a=1");
  EXPECT_EQ(body("/echo", ""), " /echo") << "an empty name is one";
  EXPECT_NE(body("/echo?a=1&a=2", " x").find("'a' more than once"), std::string::npos);
}

TEST_F(RequestLines, HeadersAreReadAsTheyWereSent) {
  router_.Add("GET", "/token", [](const HttpRequest& in, const auto&) {
    return HttpResponse{200, "text/plain", in.header("authorization").value_or("none"), {}};
  });
  const std::string text = Exchange(
      "GET /token HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer a%41b\r\nConnection: x, "
      "Close\r\n\r\n");
  EXPECT_TRUE(text.ends_with("\r\n\r\nBearer a%41b")) << text;
}

// RFC 9110, section 5.3.
TEST_F(RequestLines, LinesOfOneHeaderAreAList) {
  router_.Add("GET", "/known", [](const HttpRequest& in, const auto&) {
    return HttpResponse{IsKnown(in, "\"b\"") ? 304 : 200, "text/plain", "", {}};
  });
  const auto ask = [this](const std::string& headers) {
    return Exchange("GET /known HTTP/1.1\r\nHost: x\r\n" + headers + "Connection: close\r\n\r\n");
  };
  EXPECT_NE(ask("If-None-Match: \"a\"\r\nif-none-match: \"b\"\r\n").find(" 304 "),
            std::string::npos);
  EXPECT_NE(ask("If-None-Match: \"a\"\r\n").find(" 200 "), std::string::npos);
}

// RFC 9112, section 9.3.
TEST_F(RequestLines, AnswersSayWhetherTheConnectionIsKept) {
  const auto keeps = [this](const std::string& version, const std::string& headers) {
    RawClient client(server_->port());
    client.Send("GET /hello " + version + "\r\nHost: x\r\n" + headers + "\r\n");
    const std::string text = client.Receive("hello");
    const bool kept = text.find("\r\nConnection: keep-alive\r\n") != std::string::npos;
    EXPECT_EQ(text.find("\r\nKeep-Alive: timeout=30\r\n") != std::string::npos, kept) << text;
    EXPECT_EQ(text.find("\r\nConnection: close\r\n") == std::string::npos, kept) << text;
    if (kept) client.Send("GET /hello HTTP/1.0\r\n\r\n");
    EXPECT_EQ(client.Receive().find("200 OK") != std::string::npos, kept);
    return kept;
  };
  EXPECT_TRUE(keeps("HTTP/1.1", ""));
  EXPECT_TRUE(keeps("HTTP/1.0", "Connection: keep-alive\r\n"));
  EXPECT_TRUE(keeps("HTTP/1.0", "Connection: Keep-Alive\r\n"));
  EXPECT_TRUE(keeps("HTTP/1.0", "Connection: TE, Keep-Alive\r\n"));
  EXPECT_FALSE(keeps("HTTP/1.0", ""));
  EXPECT_FALSE(keeps("HTTP/1.1", "Connection: close\r\n"));
  EXPECT_FALSE(keeps("HTTP/1.1", "Connection: keep-alive, CLOSE\r\n"));
}

// RFC 9110, section 10.1.1: the client needn't send a body that is refused.
TEST_F(RequestLines, ABodyThatIsTooLargeIsRefusedBeforeItIsSent) {
  router_.Add("POST", "/take", [](const HttpRequest& in, const auto&) {
    return HttpResponse{200, "text/plain", in.read_body(), {}};
  });
  const std::string text =
      Exchange("POST /take HTTP/1.1\r\nHost: x\r\nExpect: 100-continue\r\nContent-Length: " +
               std::to_string(HttpOptions().max_body_bytes + 1) + "\r\n\r\n");
  EXPECT_EQ(text.find("100 Continue"), std::string::npos) << text;
  EXPECT_NE(text.find(" 413 "), std::string::npos) << text;
}

// RFC 9110, sections 6.6.1 and 8.6.
TEST_F(RequestLines, AnswersHaveADateAndUnchangedOnesNoLength) {
  router_.Add("GET", "/same", [](const auto&, const auto&) {
    return HttpResponse{304, "", "", {}};
  });
  const std::string same = Exchange("GET /same HTTP/1.1\r\nHost: x\r\nConnection: Close\r\n\r\n");
  EXPECT_NE(same.find(" 304 "), std::string::npos) << same;
  EXPECT_EQ(same.find("Content-Length"), std::string::npos) << same;
  EXPECT_NE(same.find("\r\nDate: "), std::string::npos) << same;
  const std::string head = Exchange("HEAD /hello HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
  EXPECT_EQ(head.find("Accept-Ranges"), std::string::npos) << "as GET says nothing of it";
  EXPECT_NE(head.find("\r\nContent-Length: 5\r\n"), std::string::npos) << head;
  EXPECT_NE(same.find(" GMT\r\n"), std::string::npos) << same;
}

}  // namespace
}  // namespace waystone
