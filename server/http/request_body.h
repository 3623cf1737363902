// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "core/base/clock.h"
#include "server/http/http_server.h"

// How bodies of requests are read: inside server/http only.
namespace waystone {

// Bytes of all bodies that are in memory. Thread-safe.
class BodyBudget {
 public:
  explicit BodyBudget(int64_t limit) : limit_(limit) {}
  bool Take(int64_t bytes) { return (used_ += bytes) <= limit_; }
  void Return(int64_t bytes) { used_ -= bytes; }

 private:
  const int64_t limit_;
  std::atomic<int64_t> used_ = 0;
};

// Takes the next bytes of a body and says whether to go on.
using BodyReceiver = std::function<bool(const char* data, size_t size)>;
// Hands a body over piece by piece; whether all of it was taken.
using BodyReader = std::function<bool(const BodyReceiver& receive)>;

// The body of one request, read at most once. The budget has to outlive it.
class RequestBody {
 public:
  RequestBody(BodyReader reader, const HttpOptions& options, BodyBudget& budget);
  ~RequestBody();
  RequestBody(const RequestBody&) = delete;
  RequestBody& operator=(const RequestBody&) = delete;

  // Throws MapError: kTooSlow past options.body_timeout_s, kBusy when the budget is spent,
  // kPayloadTooLarge above options.max_body_bytes, kBadRequest when the connection ends early.
  std::string Read();

  // Reads what is left. Returns whether the connection is at the end of the body, and so at the
  // start of the next request.
  bool Drain();

 private:
  template <class Take>
  bool ReadInto(const Take& take);

  BodyReader reader_;
  BodyBudget& budget_;
  int64_t limit_;
  Clock::time_point end_;
  int64_t count_ = 0;
  int64_t taken_ = 0;     // of the budget
  bool late_ = false;     // the time was over
  bool crowded_ = false;  // the budget was
  bool started_ = false;
  bool complete_ = false;
};

}  // namespace waystone
