// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <utility>

namespace waystone {

// Lets `running` queries compute at once and `waiting` more wait for their turn; the next one is
// turned away at once. Connections hold threads of their own, so that a slow client costs no
// query its core. Thread-safe.
class QueryGate {
 public:
  using Deadline = std::optional<std::chrono::steady_clock::time_point>;

  QueryGate(int running, int waiting) : running_(running), free_(running), seats_(waiting) {}
  QueryGate(const QueryGate&) = delete;
  QueryGate& operator=(const QueryGate&) = delete;

  // A query's turn, from Enter() to its destruction.
  class Turn {
   public:
    explicit Turn(QueryGate* gate) : gate_(gate) {}
    Turn(Turn&& other) noexcept : gate_(std::exchange(other.gate_, nullptr)) {}
    Turn& operator=(Turn&&) = delete;
    ~Turn() {
      if (gate_) gate_->Leave();
    }

   private:
    QueryGate* gate_;
  };

  // Waits for a turn. Throws MapError(kBusy) when all seats are taken.
  [[nodiscard]] Turn Enter();
  // The same, but nothing when the deadline passes first.
  [[nodiscard]] std::optional<Turn> Enter(const Deadline& deadline);

  // How many compute and how many wait, now.
  struct Load {
    int running = 0;
    int waiting = 0;
  };
  Load load() const;

 private:
  void Leave();

  const int running_;
  mutable std::mutex mutex_;
  std::condition_variable freed_;
  int free_;
  int seats_;
  int waiting_ = 0;
};

}  // namespace waystone
