// SPDX-License-Identifier: Apache-2.0
// The connection to a real PostgreSQL, also one that is frozen.
#include "registry/postgres_database.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <thread>

#include "core/base/clock.h"
#include "core/base/error.h"
#include "tests/registry/postgres_server.h"

namespace waystone::postgres {
namespace {

class DatabaseTest : public testing::Test {
 protected:
  static void TearDownTestSuite() { server_.reset(); }

  void SetUp() override {
    if (!PostgresServer::Programs()) {
      GTEST_SKIP() << "PostgreSQL isn't installed (apt-get install postgresql)";
    }
    if (!server_) server_ = std::make_unique<PostgresServer>();
  }

  static std::string Refusal(ErrorCode code, const std::function<void()>& act) {
    try {
      act();
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      return error.what();
    }
    ADD_FAILURE() << "no error";
    return "";
  }

  static inline std::unique_ptr<PostgresServer> server_;
};

TEST_F(DatabaseTest, StatementsAreAnswered) {
  Database database(server_->url());
  EXPECT_EQ(Cell(database.Run("SELECT 1; SELECT 2"), 0, 0), "2") << "the last one's result";
  const std::string large(5'000'000, 'x');  // more than a socket takes at once
  EXPECT_EQ(Number(database.Run("SELECT length($1)", {large}), 0, 0), std::ssize(large));
  EXPECT_EQ(Cell(database.Run("SELECT repeat($1, 5000000)", {"y"}), 0, 0).size(), 5'000'000U);
  EXPECT_NE(Refusal(ErrorCode::kFileUnreadable, [&] { database.Run("SELECT 1; SELECT 1 / 0"); })
                .find("division by zero"),
            std::string::npos);
  EXPECT_EQ(Number(database.Run("SELECT 3"), 0, 0), 3) << "after an error";
  database.Run("LISTEN waystone");
  EXPECT_FALSE(database.TakeNotifications());
  database.Run("NOTIFY waystone");
  EXPECT_TRUE(database.TakeNotifications());
}

TEST_F(DatabaseTest, AFrozenServerIsGivenUp) {
  constexpr double kPatienceS = 30;  // on a machine that is busy
  Database database(server_->url(), {}, 1);
  const auto backend = static_cast<pid_t>(Number(database.Run("SELECT pg_backend_pid()"), 0, 0));
  ASSERT_GT(backend, 0);
  ASSERT_EQ(kill(backend, SIGSTOP), 0);
  const Clock::time_point start = Clock::now();
  EXPECT_EQ(Refusal(ErrorCode::kRegistryUnavailable, [&] { Transaction transaction(database); }),
            "the registry's database: no answer within 1 s; check the address postgresql://... and "
            "that the server runs");
  EXPECT_FALSE(database.connected());
  Refusal(ErrorCode::kRegistryUnavailable, [&] { database.Run("SELECT 1"); });
  EXPECT_LT(SecondsSince(start), kPatienceS);
  kill(backend, SIGCONT);
  EXPECT_EQ(Cell(Database(server_->url(), {}, kPatienceS).Run("SELECT 1"), 0, 0), "1");
}

TEST_F(DatabaseTest, AStopEndsTheWaitForAFrozenServer) {
  constexpr double kPatienceS = 30;
  std::stop_source stop;
  Database database(server_->url(), stop.get_token());
  const auto backend = static_cast<pid_t>(Number(database.Run("SELECT pg_backend_pid()"), 0, 0));
  ASSERT_GT(backend, 0);
  ASSERT_EQ(kill(backend, SIGSTOP), 0);
  const Clock::time_point start = Clock::now();
  std::jthread stopping([&stop] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    stop.request_stop();
  });
  EXPECT_NE(Refusal(ErrorCode::kRegistryUnavailable, [&] { database.Run("SELECT 1"); })
                .find("no answer until the program was stopped"),
            std::string::npos);
  EXPECT_LT(SecondsSince(start), kPatienceS);
  EXPECT_FALSE(database.connected());
  kill(backend, SIGCONT);
}

TEST_F(DatabaseTest, AServerThatIsKilledIsSaid) {
  Database database(server_->url());
  server_->Stop();
  Refusal(ErrorCode::kRegistryUnavailable, [&] { database.Run("SELECT 1"); });
  EXPECT_FALSE(database.connected());
  Refusal(ErrorCode::kRegistryUnavailable, [&] { database.Run("SELECT 1"); });
  server_->Start();
}

}  // namespace
}  // namespace waystone::postgres
