// SPDX-License-Identifier: Apache-2.0
// Memory runs out while requests are read, answered and logged.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "api/json.h"
#include "server/http/http_server.h"
#include "server/service/application.h"
#include "tests/faults/memory/attack.h"
#include "tests/faults/memory/failing_memory.h"
#include "tests/faults/memory/made_places.h"
#include "tests/faults/memory/sent_requests.h"
#include "tests/server/http/raw_client.h"

namespace waystone {
namespace {

MapCatalog::Indices Maps() {
  return {{"photos", MapIndex::Build(PhotoMap())}, {"panoramas", MapIndex::Build(PanoramaMap())}};
}

// An answer without what differs from run to run.
std::string Timeless(const HttpResponse& response) {
  Json json = Json::parse(response.body, nullptr, false);
  if (!json.is_object()) return response.body.substr(0, response.body.find('\n'));  // metrics count
  json.erase("timing_ms");
  if (!json.contains("images")) return json.dump();
  for (Json& image : json["images"]) image.erase("timing_ms");
  return json.dump();
}

class RequestMemory : public testing::TestWithParam<SentRequest> {
 protected:
  const tbb::global_control one_thread_{tbb::global_control::max_allowed_parallelism, 1};
  int lines_ = 0;
  Application app_{Maps(), {}, {[this](const std::string&) { ++lines_; }, {}}};
};

TEST_P(RequestMemory, IsAnsweredAsEverOrBy503) {
  const SentRequest& sent = GetParam();
  const HttpRequest request = sent.ToRequest();
  const HttpResponse expected = app_.Answer(request);
  EXPECT_EQ(expected.status, sent.status) << expected.body;
  std::optional<HttpResponse> response;
  int refused = 0;
  const MemoryAttack attack = AttackMemory(
      sent.name,
      [&] {
        response.reset();
        response = app_.Answer(request);
      },
      [&](bool threw) {
        if (threw) return;
        if (response->status == 503) {
          ++refused;
          ASSERT_EQ(Json::parse(response->body)["code"], "out_of_memory");
          return;
        }
        ASSERT_EQ(response->status, expected.status) << response->body;
        ASSERT_EQ(Timeless(*response), Timeless(expected));
      },
      {.single = 100, .lasting = 20});
  EXPECT_GT(refused + attack.threw, 10);
  EXPECT_EQ(app_.Answer(request).status, sent.status);
}

INSTANTIATE_TEST_SUITE_P(Requests, RequestMemory, testing::ValuesIn(SentRequests()),
                         [](const auto& param) { return param.param.name; });

// All threads of the server but that of the test.
class ServerMemory : public testing::Test {
 protected:
  ServerMemory() { server_.Start(); }

  // What comes back until the server closes.
  std::string Ask(const std::string& bytes) const {
    RawClient client(server_.port());
    client.Send(bytes);
    return client.Receive();
  }

  // Each request with one allocation failing and with all from one on.
  void Attack(const std::string& name, const std::string& bytes, int64_t most) {
    int64_t all = 0;
    {
      const FailingMemory counted(CountedThreads::kOthers, {});
      EXPECT_TRUE(Ask(bytes).starts_with("HTTP/1.1 200")) << name;
      all = FailingMemory::count();
    }
    ASSERT_GT(all, 0) << name;
    int runs = 0, hit = 0, answered = 0, refused = 0, closed = 0;
    for (int64_t i = 0; i < std::min(all, most); ++i) {
      for (const int64_t more : {int64_t{0}, kAllAfter}) {
        const int64_t allocation = i * all / std::min(all, most);
        std::string answer;
        {
          const FailingMemory failing(CountedThreads::kOthers, {allocation, more});
          answer = Ask(bytes);
        }
        ++runs;
        hit += FailingMemory::failed() > 0 ? 1 : 0;
        const bool is_503 = answer.starts_with("HTTP/1.1 503");
        answered += answer.starts_with("HTTP/1.1 200") ? 1 : 0;
        refused += is_503 ? 1 : 0;
        closed += answer.empty() ? 1 : 0;
        ASSERT_TRUE(answer.empty() || is_503 || answer.starts_with("HTTP/1.1 200"))
            << allocation << ": " << answer;
        ASSERT_TRUE(!is_503 || answer.find("\"code\":\"out_of_memory\"") != std::string::npos);
        ASSERT_TRUE(Ask(kHealth).starts_with("HTTP/1.1 200")) << "after " << allocation;
      }
    }
    std::cout << name << ": " << all << " allocations, " << runs << " runs, " << hit << " hit, "
              << answered << " answered, " << refused << " refused, " << closed << " closed\n";
    EXPECT_GT(hit, runs / 2) << name;
  }

  static constexpr const char* kHealth =
      "GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
  Application app_{Maps(), {}, {}};
  HttpServer server_{{.port = 0, .request_threads = 4},
                     [this](const HttpRequest& request) { return app_.Answer(request); }};
};

TEST_F(ServerMemory, AHealthCheckIsAnsweredOrItsConnectionClosed) {
  Attack("health check", kHealth, 40);
}

TEST_F(ServerMemory, AQueryIsAnsweredOrRefusedOrItsConnectionClosed) {
  Attack("query", PhotoQuery(""), 30);
}

TEST_F(ServerMemory, SoIsOneThatComputesInAThreadOfItsOwn) {
  Attack("query with a deadline", PhotoQuery("?deadline_ms=20000"), 30);
}

TEST(StartMemory, AServerStartsOrThrows) {
  const MemoryAttack attack = AttackMemory(
      "start a server",
      [] {
        try {
          HttpServer server({.port = 0, .request_threads = 3},
                            [](const HttpRequest&) { return HttpResponse(); });
          server.Start();
        } catch (const MapError& error) {  // a thread's stack
          EXPECT_EQ(error.code(), ErrorCode::kOutOfMemory) << error.what();
          throw std::bad_alloc();
        }
      },
      [](bool) {});
  EXPECT_GT(attack.threw, attack.runs / 2);
}

}  // namespace
}  // namespace waystone
