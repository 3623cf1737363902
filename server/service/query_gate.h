// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <list>
#include <mutex>
#include <optional>
#include <utility>

namespace waystone {

// Lets `running` queries compute at once, and `waiting` more wait for their turn in the order of
// their arrival; the next one is turned away at once. Thread-safe.
class QueryGate {
 public:
  using Clock = std::chrono::steady_clock;
  using Deadline = std::optional<Clock::time_point>;

  QueryGate(int running, int waiting) : running_(running), free_(running), seats_(waiting) {}
  QueryGate(const QueryGate&) = delete;
  QueryGate& operator=(const QueryGate&) = delete;

  // A query's turn, from Enter() to its destruction.
  class Turn {
   public:
    explicit Turn(QueryGate* gate) : gate_(gate) {}
    Turn(Turn&& other) noexcept
        : gate_(std::exchange(other.gate_, nullptr)), start_(other.start_) {}
    Turn& operator=(Turn&&) = delete;
    ~Turn() {
      if (gate_) gate_->Leave(Clock::now() - start_);
    }

   private:
    QueryGate* gate_;
    Clock::time_point start_ = Clock::now();
  };

  // Waits for a turn. Throws BusyError when all seats are taken, with the time until those who have
  // one now will have had their turns, by how long recent turns took: 1 to 60 s. Throws
  // MapError(kNotReady) once the gate is closed.
  [[nodiscard]] Turn Enter();
  // The same, but nothing when the deadline passes first.
  [[nodiscard]] std::optional<Turn> Enter(const Deadline& deadline);

  // Turns away whoever waits, and all who come from now on, with MapError(kNotReady).
  void Close();

  // How many compute and how many wait, now.
  struct Load {
    int running = 0;
    int waiting = 0;
  };
  Load load() const;

 private:
  // The place of a query that waits.
  struct Place {
    std::condition_variable changed;
    bool called = false;  // has a turn
  };

  [[noreturn]] static void FailClosed();
  void Leave(Clock::duration took);
  int RetryAfterS() const;  // with the lock held

  const int running_;
  mutable std::mutex mutex_;
  int free_;
  int seats_;
  std::list<Place> waiting_;  // in the order of their coming
  bool closed_ = false;
  double turn_s_ = 0;  // how long recent turns took, the last ones count more; 0 before the first
};

}  // namespace waystone
