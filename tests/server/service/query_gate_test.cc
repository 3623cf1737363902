// SPDX-License-Identifier: Apache-2.0
#include "server/service/query_gate.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "server/http/problem.h"

namespace waystone {
namespace {

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
}  // namespace
}  // namespace waystone
