// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <mutex>

namespace waystone {

// Lets `running` queries compute at once and `waiting` more wait for their turn; the next one is
// turned away at once. Connections hold threads of their own, so that a slow client costs no
// query its core. Thread-safe.
class QueryGate {
 public:
  QueryGate(int running, int waiting) : free_(running), seats_(waiting) {}
  QueryGate(const QueryGate&) = delete;
  QueryGate& operator=(const QueryGate&) = delete;

  // A query's turn, from Enter() to its destruction.
  class Turn {
   public:
    explicit Turn(QueryGate* gate) : gate_(gate) {}
    ~Turn() { gate_->Leave(); }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

   private:
    QueryGate* gate_;
  };

  // Waits for a turn. Throws MapError(kBusy) when all seats are taken.
  [[nodiscard]] Turn Enter();

 private:
  void Leave();

  std::mutex mutex_;
  std::condition_variable freed_;
  int free_;
  int seats_;
};

}  // namespace waystone
