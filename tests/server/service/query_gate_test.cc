// SPDX-License-Identifier: Apache-2.0
#include "server/service/query_gate.h"

#include <gtest/gtest.h>

#include <atomic>
#include <barrier>
#include <chrono>
#include <future>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "server/http/problem.h"

namespace waystone {
namespace {

// Until that many sit in the gate's queue.
void WaitForQueue(const QueryGate& gate, int waiting) {
  while (gate.load().waiting != waiting) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
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
    WaitForQueue(gate, 1);
    EXPECT_THROW(static_cast<void>(gate.Enter()), BusyError);
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

TEST(QueryGate, ServesWhoComesFirstFirst) {
  QueryGate gate(1, 3);
  std::vector<int> order;  // a turn at a time writes it
  std::vector<std::thread> threads;
  {
    const QueryGate::Turn first = gate.Enter();
    for (int t = 0; t < 3; ++t) {
      threads.emplace_back([&, t] {
        const QueryGate::Turn turn = gate.Enter();
        order.push_back(t);
      });
      WaitForQueue(gate, t + 1);
    }
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(order, (std::vector<int>{0, 1, 2}));
}

TEST(QueryGate, ClosingTurnsAwayWhoWaitsAndWhoComes) {
  QueryGate gate(1, 1);
  const QueryGate::Turn first = gate.Enter();
  const auto enter = [&gate] {
    try {
      static_cast<void>(gate.Enter());
    } catch (const MapError& error) {
      return error.code();
    }
    return ErrorCode::kInternal;
  };
  std::future<ErrorCode> waiting = std::async(std::launch::async, enter);
  WaitForQueue(gate, 1);
  gate.Close();
  EXPECT_EQ(waiting.get(), ErrorCode::kNotReady);
  EXPECT_EQ(enter(), ErrorCode::kNotReady);
}

TEST(QueryGate, AsManyInsideAsItsNumberAndNeverMore) {
  QueryGate gate(2, 100);
  std::barrier both(2);
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
        if (i == 0) both.arrive_and_wait();  // never ends unless two are inside at once
        std::this_thread::yield();
        --inside;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(most, 2);
}

}  // namespace
}  // namespace waystone
