// SPDX-License-Identifier: Apache-2.0
// What clients do to a server, by accident or on purpose, and that others don't notice.
#include <gtest/gtest.h>
#include <httplib.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <iterator>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/base/clock.h"
#include "server/http/http_server.h"
#include "server/http/router.h"
#include "tests/server/http/raw_client.h"

namespace waystone {
namespace {

using Clients = std::vector<std::unique_ptr<RawClient>>;

// Of an answer: more than the kernel's buffers of a connection take.
constexpr size_t kLargeBytes = 12'000'000;
const std::string kHello = "GET /hello HTTP/1.1\r\nHost: x\r\n\r\n";

std::string Post(const std::string& body) {
  return "POST /length HTTP/1.1\r\nHost: x\r\nContent-Length: " + std::to_string(body.size()) +
         "\r\n\r\n" + body;
}

// Open files and sockets of this process, the server's and the clients'.
int CountDescriptors() {
  const std::filesystem::directory_iterator descriptors("/proc/self/fd");
  return static_cast<int>(std::distance(begin(descriptors), end(descriptors)));
}

class HostileClients : public testing::Test {
 protected:
  HostileClients() {
    options_.port = 0;
    router_.Add("GET", "/hello", [](const auto&, const auto&) {
      return HttpResponse{200, "text/plain", "hello", {}};
    });
    router_.Add("GET", "/healthz", [](const auto&, const auto&) {
      return HttpResponse{200, "text/plain", "ok", {}};
    });
    router_.Add("GET", "/large", [](const auto&, const auto&) {
      return HttpResponse{200, "text/plain", std::string(kLargeBytes, 'x'), {}};
    });
    router_.Add("GET", "/slow", [this](const auto&, const auto&) {
      ++slow_;
      while (!released_) std::this_thread::sleep_for(std::chrono::milliseconds(5));
      return HttpResponse{200, "text/plain", "slow", {}};
    });
    router_.Add("POST", "/length", [](const HttpRequest& in, const auto&) {
      return HttpResponse{200, "text/plain", std::to_string(in.read_body().size()) + "!", {}};
    });
  }

  void Start(const HttpServer::Admit& admit = nullptr) {
    server_ = std::make_unique<HttpServer>(
        options_, [this](const HttpRequest& in) { return router_.Dispatch(in); }, admit);
    server_->Start();
  }

  Clients Connect(int count) const {
    Clients clients;
    for (int i = 0; i < count; ++i) {
      clients.push_back(std::make_unique<RawClient>(server_->port()));
      EXPECT_TRUE(clients.back()->connected()) << i;
    }
    return clients;
  }

  std::string Exchange(const std::string& bytes) const {
    RawClient client(server_->port());
    client.Send(bytes);
    return client.Receive();
  }

  bool IsAlive() const {
    httplib::Client client(server_->url());
    const auto result = client.Get("/hello");
    return result && result->status == 200;
  }

  // The 99th percentile of so many requests, each on a connection of its own.
  double P99Ms(int count) const {
    std::vector<double> ms;
    for (int i = 0; i < count; ++i) {
      const auto start = Clock::now();
      EXPECT_TRUE(IsAlive()) << i;
      ms.push_back(MillisecondsSince(start));
    }
    std::sort(ms.begin(), ms.end());
    return ms[ms.size() * 99 / 100];
  }

  HttpOptions options_;
  Router router_;
  std::atomic<int> slow_ = 0;
  std::atomic<bool> released_ = false;
  std::unique_ptr<HttpServer> server_;
};

TEST_F(HostileClients, AnEndlessHeadIsRefusedEarly) {
  options_.max_body_bytes = 1'000'000;
  Start();
  for (const char* start : {"GET /", "GET / HTTP/1.1\r\nA: ", "GET / HTTP/1.1\r\nA: b\r\n"}) {
    RawClient client(server_->port());
    ASSERT_TRUE(client.Send(start));
    const std::string block = start[5] == ' ' && std::string(start).ends_with("b\r\n")
                                  ? "A: b\r\n"
                                  : std::string(1000, 'x');
    size_t sent = 0;
    while (sent < 100'000'000 && client.Send(block)) sent += block.size();
    // What the kernel's buffers take, not more.
    EXPECT_LT(sent, 50'000'000u) << start;
    EXPECT_TRUE(IsAlive());
  }
  EXPECT_NE(Exchange("GET /" + std::string(9000, 'x')).find(" 431 "), std::string::npos);
}

TEST_F(HostileClients, ASlowHeadIsGivenUp) {
  options_.head_timeout_s = 1;
  Start();
  RawClient client(server_->port());
  const auto start = Clock::now();
  std::thread sender([&client] {
    for (int i = 0; i < 30 && client.Send("G"); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  });
  const std::string text = client.Receive("}");
  const double took_s = SecondsSince(start);
  sender.join();
  EXPECT_NE(text.find(" 408 "), std::string::npos) << text;
  EXPECT_LT(took_s, 2.5 * WAYSTONE_SLOWDOWN);
}

// In these three, the client's patience of 10 s ends before the limits by default do.
TEST_F(HostileClients, ABodyOfWhichNothingComesIsGivenUp) {
  options_.read_timeout_s = 1;
  Start();
  RawClient client(server_->port());
  client.Send("POST /length HTTP/1.1\r\nHost: x\r\nContent-Length: 1000\r\n\r\nxx");
  const std::string text = client.Receive("}");
  EXPECT_NE(text.find(" 408 "), std::string::npos) << text;
}

TEST_F(HostileClients, AnIdleConnectionIsClosed) {
  options_.keep_alive_s = 1;
  Start();
  RawClient client(server_->port());
  client.Send(kHello);
  EXPECT_NE(client.Receive("hello").find("200 OK"), std::string::npos);
  const auto start = Clock::now();
  EXPECT_EQ(client.Receive(), "");
  EXPECT_LT(SecondsSince(start), 9) << "closed by its client";
}

TEST_F(HostileClients, AnAnswerThatIsTakenTooSlowlyIsGivenUp) {
  options_.answer_timeout_s = 1;
  Start();
  RawClient client(server_->port());
  client.Send("GET /large HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
  size_t taken = 0;
  for (const auto start = Clock::now(); SecondsSince(start) < 2.5;) {
    taken += client.Receive("x").size();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_LT(taken + client.Receive().size(), kLargeBytes);
}

TEST_F(HostileClients, ManyPoliteSlowAndIdleOnesDoNotDelayAnHonestOne) {
  Start();
  P99Ms(20);
  const double before_ms = P99Ms(200);
  Clients polite = Connect(64);
  const Clients slow = Connect(200);
  const Clients idle = Connect(500);
  std::atomic<bool> ended = false;
  std::thread politeness([&] {
    for (size_t i = 0; !ended; i = (i + 1) % polite.size()) {
      polite[i]->Send(kHello);
      EXPECT_NE(polite[i]->Receive("hello").find("200 OK"), std::string::npos);
    }
  });
  std::thread dripping([&] {
    const std::string bytes = Post(std::string(10'000, 'x'));
    for (size_t at = 0; !ended && at < bytes.size(); ++at) {
      for (const auto& client : slow) client->Send(bytes.substr(at, 1));
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  });
  const double p99_ms = P99Ms(200);
  httplib::Client health(server_->url());
  EXPECT_TRUE(health.Get("/healthz"));
  ended = true;
  politeness.join();
  dripping.join();
  const double later_ms = P99Ms(200);
  // Twice the usual, but for what a busy machine adds to a millisecond.
  EXPECT_LT(p99_ms, std::max({2 * before_ms, 2 * later_ms, 25.0 * WAYSTONE_SLOWDOWN}))
      << "before " << before_ms << ", after " << later_ms;
}

TEST_F(HostileClients, IdleConnectionsMakeRoom) {
  options_.max_connections = 8;
  Start();
  const Clients idle = Connect(50);
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(IsAlive()) << i;
}

TEST_F(HostileClients, OneConnectionIsServedUntilAnotherComes) {
  options_.max_connections = 1;
  Start();
  RawClient client(server_->port());
  for (int i = 0; i < 3; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(150));  // the loop has looked around
    ASSERT_TRUE(client.Send(kHello));
    ASSERT_NE(client.Receive("hello").find("200 OK"), std::string::npos) << i;
  }
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(IsAlive()) << i;
  EXPECT_EQ(client.Receive(), "") << "it made room";
}

TEST_F(HostileClients, HealthIsAnsweredWhileAllThreadsAreBusy) {
  options_.request_threads = 2;
  Start();
  Clients busy = Connect(6);
  for (const auto& client : busy) client->Send("GET /slow HTTP/1.1\r\nHost: x\r\n\r\n");
  while (slow_ < 2) std::this_thread::yield();
  httplib::Client client(server_->url());
  const auto result = client.Get("/healthz");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->body, "ok");
  EXPECT_EQ(slow_, 2) << "a place is kept for health checks";
  released_ = true;
  for (const auto& each : busy) {
    EXPECT_NE(each->Receive("slow").find("200 OK"), std::string::npos);
  }
}

TEST_F(HostileClients, PipelinedRequestsAreAllAnsweredInOrder) {
  Start();
  RawClient client(server_->port());
  std::string requests;
  for (int i = 0; i < 20; ++i) requests += kHello + Post(std::string(i, 'x')) + "\r\n";
  client.Send(requests + "GET /healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
  const std::string text = client.Receive();
  size_t at = 0;
  for (int i = 0; i < 20; ++i) {
    at = text.find("hello", at);
    ASSERT_NE(at, std::string::npos) << i;
    at = text.find("\r\n\r\n" + std::to_string(i) + "!", at);
    ASSERT_NE(at, std::string::npos) << i;
  }
  EXPECT_TRUE(text.ends_with("ok")) << text;
}

TEST_F(HostileClients, EmptyLinesAreSkippedUpToABound) {
  Start();
  RawClient split(server_->port());
  split.Send("\r");
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  split.Send("\n" + kHello);
  EXPECT_NE(split.Receive("hello").find("200 OK"), std::string::npos);
  std::string lines;
  for (int i = 0; i < 8; ++i) lines += "\r\n";
  RawClient client(server_->port());
  for (int i = 0; i < 3; ++i) {  // before each request
    client.Send(lines + kHello);
    EXPECT_NE(client.Receive("hello").find("200 OK"), std::string::npos) << i;
  }
  client.Send(lines + "\r\n" + kHello);
  EXPECT_NE(client.Receive().find(" 400 "), std::string::npos);
}

TEST_F(HostileClients, EmptyLinesKeepNoConnection) {
  options_.keep_alive_s = 1;
  Start();
  RawClient client(server_->port());
  client.Send(kHello);
  EXPECT_NE(client.Receive("hello").find("200 OK"), std::string::npos);
  const auto start = Clock::now();
  for (const char* bytes : {"\r\n", "\r", "\n"}) {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    client.Send(bytes);
  }
  EXPECT_EQ(client.Receive(), "");
  EXPECT_LT(SecondsSince(start), 6) << "closed by its client, or after the time for a head";
}

TEST_F(HostileClients, AHalfClosedClientGetsItsAnswer) {
  Start();
  for (const std::string& request : {kHello, Post("12345")}) {
    RawClient client(server_->port());
    client.Send(request);
    client.EndSending();
    EXPECT_NE(client.Receive().find("200 OK"), std::string::npos) << request;
  }
}

TEST_F(HostileClients, AnswersThatNobodyReadsAreDropped) {
  options_.write_timeout_s = 1;
  options_.max_bodies_bytes = 40'000'000;
  Start();
  const int unconnected = CountDescriptors();
  Clients silent = Connect(8);
  for (const auto& client : silent) client->Send("GET /large HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_TRUE(IsAlive());
  // Reading before the server has closed all eight would be what it waits for.
  const auto start = Clock::now();
  while (CountDescriptors() > unconnected + 8 && SecondsSince(start) < 60) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  EXPECT_LE(CountDescriptors(), unconnected + 8);
  for (const auto& client : silent) EXPECT_LT(client->Receive().size(), kLargeBytes);
  EXPECT_TRUE(IsAlive());
}

TEST_F(HostileClients, ABodyIsReadForThoseWhoMaySendOne) {
  Start([](const std::string& authorization) { return authorization == "Bearer right"; });
  const auto head = [](const std::string& token) {
    return "POST /length HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer " + token +
           "\r\nExpect: 100-continue\r\nContent-Length: 3\r\n\r\n";
  };
  RawClient known(server_->port());
  known.Send(head("right"));
  EXPECT_NE(known.Receive("\r\n\r\n").find("100 Continue"), std::string::npos);
  known.Send("abc");
  EXPECT_NE(known.Receive("3!").find("200 OK"), std::string::npos);
  const std::string text = Exchange(head("wrong"));
  EXPECT_EQ(text.find("100 Continue"), std::string::npos) << text;
  EXPECT_NE(text.find(" 401 "), std::string::npos) << text;
}

TEST_F(HostileClients, StoppingWaitsForNoClient) {
  options_.stop_timeout_s = 2;
  Start();
  const Clients idle = Connect(20);
  RawClient dripping(server_->port());
  dripping.Send("POST /length HTTP/1.1\r\nHost: x\r\nContent-Length: 1000\r\n\r\nxx");
  RawClient deaf(server_->port());
  deaf.Send("GET /large HTTP/1.1\r\nHost: x\r\n\r\n");
  RawClient honest(server_->port());
  honest.Send("GET /slow HTTP/1.1\r\nHost: x\r\n\r\n");
  while (slow_ < 1) std::this_thread::yield();
  std::thread release([this] {
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    released_ = true;
  });
  const auto start = Clock::now();
  server_->Stop([] { ADD_FAILURE() << "the honest one's answer was ready in time"; });
  EXPECT_LT(SecondsSince(start), 4);
  release.join();
  const std::string text = honest.Receive();
  EXPECT_NE(text.find("slow"), std::string::npos) << text;
}

TEST_F(HostileClients, AStopSaysThatAnswersAreLate) {
  options_.stop_timeout_s = 1;
  Start();
  RawClient client(server_->port());
  client.Send("GET /slow HTTP/1.1\r\nHost: x\r\n\r\n");
  while (slow_ < 1) std::this_thread::yield();
  server_->Stop([this] { released_ = true; });  // waits for the slow one without
}

TEST_F(HostileClients, WhileDrainingAnswersCloseTheirConnections) {
  Start();
  RawClient client(server_->port());
  client.Send(kHello);
  EXPECT_EQ(client.Receive("hello").find("Connection: close"), std::string::npos);
  server_->Drain();
  client.Send(kHello);
  const std::string text = client.Receive();
  EXPECT_NE(text.find("Connection: close"), std::string::npos) << text;
  EXPECT_TRUE(text.ends_with("hello")) << text;
}

}  // namespace
}  // namespace waystone
