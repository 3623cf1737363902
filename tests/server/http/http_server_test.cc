// SPDX-License-Identifier: Apache-2.0
#include "server/http/http_server.h"

#include <gtest/gtest.h>
#include <httplib.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "server/http/router.h"
#include "tests/server/http/no_threads.h"
#include "tests/server/http/raw_client.h"

namespace waystone {
namespace {

constexpr int64_t kLimit = 1000;

// A server that says how long the body was.
class HttpServerTest : public testing::Test {
 protected:
  HttpServerTest() {
    router_.Add("GET", "/hello", [](const auto&, const auto&) {
      return HttpResponse{200, "text/plain", "hello", {}};
    });
    router_.Add("POST", "/length", [this](const HttpRequest& in, const auto&) {
      ++posts_;
      return HttpResponse{200, "text/plain", std::to_string(in.read_body().size()), {}};
    });
    router_.Add("POST", "/unread", [](const auto&, const auto&) -> HttpResponse {
      throw MapError(ErrorCode::kUnsupportedMedia, "not looked at");
    });
    HttpOptions options;
    options.port = 0;
    options.max_body_bytes = kLimit;
    options.keep_alive_s = 1;
    options.read_timeout_s = 1;
    server_ = std::make_unique<HttpServer>(
        options, [this](const HttpRequest& in) { return router_.Dispatch(in); });
    server_->Start();
  }

  std::string Exchange(const std::string& bytes) {
    RawClient client(server_->port());
    EXPECT_TRUE(client.connected());
    client.Send(bytes);
    return client.Receive();
  }

  Router router_;
  std::atomic<int> posts_ = 0;
  std::unique_ptr<HttpServer> server_;
};

TEST_F(HttpServerTest, AnswersOnAFreePort) {
  EXPECT_EQ(server_->url(), "http://127.0.0.1:" + std::to_string(server_->port()));
  httplib::Client client(server_->url());
  const auto result = client.Get("/hello");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->body, "hello");
  EXPECT_EQ(result->get_header_value("X-Content-Type-Options"), "nosniff");
}

TEST_F(HttpServerTest, HeadHasTheLengthWithoutTheBody) {
  const std::string text = Exchange("HEAD /hello HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
  EXPECT_NE(text.find("Content-Length: 5\r\n"), std::string::npos) << text;
  EXPECT_TRUE(text.ends_with("\r\n\r\n")) << text;
}

TEST_F(HttpServerTest, KeepsConnectionsAlive) {
  RawClient client(server_->port());
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(client.Send("GET /hello HTTP/1.1\r\nHost: x\r\n\r\n"));
    ASSERT_NE(client.Receive("hello").find("200 OK"), std::string::npos) << i;
  }
}

TEST_F(HttpServerTest, KeepAliveIsFast) {
  httplib::Client client(server_->url());
  client.set_keep_alive(true);
  ASSERT_TRUE(client.Get("/hello"));
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(client.Get("/hello"));
  // Without TCP_NODELAY each takes 40 ms.
  EXPECT_LT(std::chrono::steady_clock::now() - start,
            std::chrono::milliseconds(400 * WAYSTONE_SLOWDOWN));
}

TEST_F(HttpServerTest, BodyAtTheLimitIsReadAndOverItIsNot) {
  httplib::Client client(server_->url());
  EXPECT_EQ(client.Post("/length", std::string(kLimit, 'x'), "image/png")->body, "1000");
  EXPECT_EQ(client.Post("/length", std::string(kLimit + 1, 'x'), "image/png")->status, 413);
}

// It is known to be too large before any of it arrives; what the client sends of it before it reads
// the answer must not reset the connection.
TEST_F(HttpServerTest, ABodyDeclaredTooLargeIsRefusedAtOnce) {
  RawClient client(server_->port());
  client.Send("POST /length HTTP/1.1\r\nHost: x\r\nContent-Length: 1500\r\n\r\n");
  std::string text = client.Receive("}");  // 408 after a second if the body were waited for
  EXPECT_NE(text.find(" 413 "), std::string::npos) << text;
  EXPECT_NE(text.find("Connection: close\r\n"), std::string::npos) << text;
  for (int i = 0; i < 3; ++i) {  // for longer than the second after which a silent client is left
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    EXPECT_TRUE(client.Send(std::string(500, 'G'))) << i;
  }
  EXPECT_EQ(client.Receive(), "");
  RawClient late(server_->port());
  late.Send("POST /length HTTP/1.1\r\nHost: x\r\nContent-Length: 1500\r\n\r\n" +
            std::string(1500, 'G'));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  text = late.Receive();
  EXPECT_NE(text.find(" 413 "), std::string::npos) << text;
  EXPECT_EQ(posts_, 2);
}

TEST_F(HttpServerTest, AfterATooLargeBodyInChunksTheConnectionStillWorks) {
  RawClient client(server_->port());
  std::string chunks;
  for (int i = 0; i < 15; ++i) chunks += "64\r\n" + std::string(100, 'G') + "\r\n";
  client.Send("POST /length HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n" + chunks +
              "0\r\n\r\n");
  EXPECT_NE(client.Receive("}").find("413"), std::string::npos);
  client.Send("GET /hello HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
  const std::string text = client.Receive();
  EXPECT_NE(text.find("hello"), std::string::npos) << text;  // the body was drained
}

TEST_F(HttpServerTest, FarTooLargeBodyIsNotReadToItsEnd) {
  RawClient client(server_->port());
  client.Send("POST /length HTTP/1.1\r\nHost: x\r\nContent-Length: 999999999999\r\n\r\n");
  std::thread sender([&client] {
    const std::string block(10'000, 'G');
    for (int i = 0; i < 1000 && client.Send(block); ++i) {
    }
  });
  const std::string text = client.Receive("\r\n\r\n");
  sender.join();
  EXPECT_NE(text.find("413"), std::string::npos) << text;
}

TEST_F(HttpServerTest, ChunkedBodyHasTheSameLimit) {
  std::string chunks;
  for (int i = 0; i < 200; ++i) chunks += "64\r\n" + std::string(100, 'x') + "\r\n";
  const std::string head = "POST /length HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n";
  EXPECT_NE(Exchange(head + chunks + "0\r\n\r\n").find("413"), std::string::npos);
  EXPECT_NE(Exchange("POST /length HTTP/1.1\r\nHost: x\r\nConnection: close\r\n"
                     "Transfer-Encoding: chunked\r\n\r\n5\r\nabcde\r\n0\r\n\r\n")
                .find("\r\n\r\n5"),
            std::string::npos);
}

TEST_F(HttpServerTest, EveryPathReachesTheRouter) {
  httplib::Client client(server_->url());
  for (const char* path :
       {"/%0A", "/a%0D%0Ab", "/%00", "/%FF", "/a//b", "/..", "/hello%2F", "/%2Fhello"}) {
    const auto result = client.Get(path);
    ASSERT_TRUE(result) << path;
    EXPECT_NE(result->body.find("no resource at /"), std::string::npos) << result->body;
  }
}

TEST_F(HttpServerTest, FormsAreBodiesLikeOthers) {
  router_.Add("POST", "/type", [](const HttpRequest& in, const auto&) {
    const std::string body = in.read_body();
    return HttpResponse{200, "text/plain", in.header("content-type").value_or("") + body, {}};
  });
  httplib::Client client(server_->url());
  const auto result = client.Post("/type", "--x--", "multipart/form-data; boundary=x");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->body, "multipart/form-data; boundary=x--x--");
  const std::string large = "--x\r\n\r\n" + std::string(kLimit, 'y') + "--x--";
  EXPECT_EQ(client.Post("/type", large, "multipart/form-data; boundary=x")->status, 413);
}

TEST_F(HttpServerTest, SlowBodiesAreGivenUp) {
  HttpOptions options;
  options.port = 0;
  options.body_timeout_s = 1;
  HttpServer server(options, [this](const HttpRequest& in) { return router_.Dispatch(in); });
  server.Start();
  RawClient client(server.port());
  client.Send("POST /length HTTP/1.1\r\nHost: x\r\nContent-Length: 1000\r\n\r\n");
  const auto start = std::chrono::steady_clock::now();
  std::thread sender([&client] {
    for (int i = 0; i < 20 && client.Send("x"); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  });
  const std::string text = client.Receive("}");
  sender.join();
  EXPECT_NE(text.find(" 408 "), std::string::npos) << text;
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(4));
}

TEST_F(HttpServerTest, BodiesHaveABudgetTogether) {
  HttpOptions options;
  options.port = 0;
  options.max_body_bytes = 1000;
  options.max_bodies_bytes = 1500;
  HttpServer server(options, [this](const HttpRequest& in) { return router_.Dispatch(in); });
  server.Start();
  RawClient first(server.port());
  first.Send("POST /length HTTP/1.1\r\nHost: x\r\nContent-Length: 1000\r\n\r\n" +
             std::string(900, 'x'));
  httplib::Client second(server.url());
  int status = 0;
  for (int i = 0; i < 100 && status != 429; ++i) {
    status = second.Post("/length", std::string(1000, 'x'), "image/png")->status;
  }
  EXPECT_EQ(status, 429);
  first.Send(std::string(100, 'x'));
  EXPECT_NE(first.Receive("\r\n\r\n1000").find("200 OK"), std::string::npos);
  EXPECT_EQ(second.Post("/length", std::string(1000, 'x'), "image/png")->status, 200);
}

TEST_F(HttpServerTest, ConnectionsBeyondTheThreadsWait) {
  HttpOptions options;
  options.port = 0;
  options.request_threads = 2;
  HttpServer server(options, [this](const HttpRequest& in) { return router_.Dispatch(in); });
  server.Start();
  std::vector<std::thread> threads;
  std::atomic<int> good = 0;
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&] {
      httplib::Client client(server.url());
      const auto result = client.Get("/hello", {{"Connection", "close"}});
      good += result && result->status == 200;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(good, 8);
}

TEST_F(HttpServerTest, UnreadBodyIsNotTakenForTheNextRequest) {
  RawClient client(server_->port());
  const std::string smuggled = "GET /smuggled HTTP/1.1\r\nHost: x\r\n\r\n";
  client.Send("POST /unread HTTP/1.1\r\nHost: x\r\nContent-Length: " +
              std::to_string(smuggled.size()) + "\r\n\r\n" + smuggled);
  EXPECT_NE(client.Receive("}").find("415"), std::string::npos);
  client.Send("GET /hello HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
  const std::string text = client.Receive();
  EXPECT_EQ(text.find("404"), std::string::npos) << text;
  EXPECT_NE(text.find("hello"), std::string::npos) << text;
}

TEST_F(HttpServerTest, EncodedBodiesAreRefused) {
  const std::string text = Exchange(
      "POST /length HTTP/1.1\r\nHost: x\r\nContent-Encoding: gzip\r\nContent-Length: 3\r\n\r\nabc");
  EXPECT_NE(text.find("415"), std::string::npos) << text;
  EXPECT_EQ(posts_, 0);
}

TEST_F(HttpServerTest, LengthsThatAreNoneAreRefusedAndTheConnectionCloses) {
  for (const char* header :
       {"Content-Length: abc", "Content-Length: -5", "Content-Length: 5\r\nContent-Length: 6",
        "Content-Length: 5\r\nTransfer-Encoding: chunked", "Content-Length: 99999999999999999999",
        "Content-Length: 0x5", "Content-Length: 5 5"}) {
    const std::string text = Exchange(std::string("POST /length HTTP/1.1\r\nHost: x\r\n") + header +
                                      "\r\n\r\nhelloGET /hello HTTP/1.1\r\n\r\n");
    EXPECT_NE(text.find(" 400 "), std::string::npos) << header << '\n' << text;
    EXPECT_EQ(text.find("200 OK"), std::string::npos) << header << '\n' << text;
    EXPECT_NE(text.find("application/problem+json"), std::string::npos) << text;
  }
  EXPECT_EQ(posts_, 0);
}

TEST_F(HttpServerTest, BodyThatEndsEarlyIsABadRequest) {
  for (const std::string body :
       {"Content-Length: 10\r\n\r\nabc", "Transfer-Encoding: chunked\r\n\r\na\r\nabc"}) {
    RawClient client(server_->port());
    client.Send("POST /length HTTP/1.1\r\nHost: x\r\n" + body);
    client.EndSending();
    const std::string text = client.Receive();
    EXPECT_NE(text.find(" 400 "), std::string::npos) << text;
    EXPECT_NE(text.find("ended before the request body did"), std::string::npos) << text;
  }
}

TEST_F(HttpServerTest, WhatIsNoHttpIsAProblemToo) {
  const std::string text = Exchange("what is this\r\n\r\n");
  EXPECT_NE(text.find(" 400 "), std::string::npos) << text;
  EXPECT_NE(text.find("\"code\":\"bad_request\""), std::string::npos) << text;
}

TEST_F(HttpServerTest, OtherMethodsAreRefusedWithTheirBodies) {
  for (const char* method : {"PUT", "DELETE", "PATCH", "OPTIONS"}) {
    const std::string text =
        Exchange(std::string(method) + " /hello HTTP/1.1\r\nHost: x\r\nContent-Length: 0\r\n\r\n");
    EXPECT_NE(text.find(" 405 "), std::string::npos) << text;
    EXPECT_NE(text.find("Allow: GET, HEAD\r\n"), std::string::npos) << text;
  }
  EXPECT_NE(
      Exchange("GET /hello HTTP/1.1\r\nHost: x\r\nContent-Length: 5\r\n\r\nhello").find(" 400 "),
      std::string::npos);
}

TEST_F(HttpServerTest, RangesAndCompressionAreLeftUndone) {
  httplib::Client client(server_->url());
  for (const char* range : {"bytes=0-1", "bytes=0-1,0-1,0-1", "bytes=0-,0-,0-,0-,0-,0-,0-", "x"}) {
    const auto result = client.Get("/hello", {{"Range", range}, {"Accept-Encoding", "br, gzip"}});
    ASSERT_TRUE(result) << range;
    EXPECT_EQ(result->status, 200);
    EXPECT_EQ(result->body, "hello");
  }
  const auto error = client.Get("/nowhere", {{"Range", "bytes=0-1"}});
  ASSERT_TRUE(error);
  EXPECT_EQ(error->status, 404);
  EXPECT_TRUE(error->body.ends_with("}"));
}

TEST_F(HttpServerTest, ManyConnectionsAtOnceDoNotWaitForRetries) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<std::thread> threads;
  std::atomic<int> good = 0;
  for (int i = 0; i < 60; ++i) {
    threads.emplace_back([&] {
      httplib::Client client(server_->url());
      const auto result = client.Get("/hello", {{"Connection", "close"}});
      if (result && result->status == 200) ++good;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(good, 60);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
}

TEST_F(HttpServerTest, StopFinishesWhatIsAtHand) {
  std::atomic<bool> inside = false;
  router_.Add("GET", "/slow", [&](const auto&, const auto&) {
    inside = true;
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    return HttpResponse{200, "text/plain", "slow", {}};
  });
  std::string body;
  std::thread client([&] {
    const auto result = httplib::Client(server_->url()).Get("/slow");
    if (result) body = result->body;
  });
  while (!inside) std::this_thread::yield();
  server_->Stop();
  client.join();
  EXPECT_EQ(body, "slow");
  EXPECT_FALSE(httplib::Client(server_->url()).Get("/hello"));
}

TEST(HttpServer, AThreadThatCannotBeStartedIsSaid) {
  HttpServer server({.port = 0}, [](const HttpRequest&) { return HttpResponse(); });
  try {
    const NoThreads none;
    server.Start();
    FAIL() << "started";
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kOutOfMemory);
    EXPECT_TRUE(std::string(error.what()).starts_with("cannot start a thread (")) << error.what();
  }
}

TEST(HttpServer, TakenPortIsSaid) {
  HttpOptions options;
  options.port = 0;
  const auto dispatch = [](const HttpRequest&) { return HttpResponse(); };
  const HttpServer first(options, dispatch);
  options.port = first.port();
  try {
    const HttpServer second(options, dispatch);
    FAIL() << "two servers share port " << options.port;
  } catch (const MapError& error) {
    EXPECT_NE(std::string(error.what()).find("--port"), std::string::npos) << error.what();
  }
}

TEST(HttpServer, OtherMachinesAreLetInOnlyOnPurpose) {
  HttpOptions options;
  options.port = 0;
  for (const char* host : {"0.0.0.0", "::", "192.168.1.5", "example.org", "", "127.example.org",
                           "127.0.0.1.example.org", "::ffff:1.2.3.4"}) {
    options.host = host;
    options.insecure = false;
    EXPECT_THROW(options.Check(), MapError) << host;
    options.insecure = true;
    EXPECT_NO_THROW(options.Check()) << host;
  }
  options.insecure = false;
  for (const char* host : {"127.0.0.1", "127.0.0.2", "127.255.0.9", "localhost", "::1"}) {
    options.host = host;
    EXPECT_NO_THROW(options.Check()) << host;
  }
  options.port = 65536;
  EXPECT_THROW(options.Check(), MapError);
}

}  // namespace
}  // namespace waystone
