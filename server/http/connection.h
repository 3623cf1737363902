// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/clock.h"
#include "server/http/chunked_body.h"
#include "server/http/http_engine.h"
#include "server/http/http_server.h"
#include "server/http/request_head.h"

namespace waystone {

// What a connection waits for.
enum class ConnectionState {
  kHead,     // the client's next request
  kBody,     // the rest of it
  kAnswer,   // ours
  kWriting,  // the client taking the answer
  kClosing,  // the client's close: ours, with bytes unread, would be a reset that loses the answer
};

// Bytes held for clients, with a limit. Take() counts them in any case, and says whether the limit
// still holds. Not thread-safe.
class ByteBudget {
 public:
  explicit ByteBudget(int64_t limit) : limit_(limit) {}
  bool Take(int64_t bytes) { return (used_ += bytes) <= limit_; }
  void Return(int64_t bytes) { used_ -= bytes; }
  bool spent() const { return used_ > limit_; }

 private:
  const int64_t limit_;
  int64_t used_ = 0;
};

// The budgets of all connections of a server.
struct ByteBudgets {
  ByteBudget bodies;
  ByteBudget answers;
};

// One client's bytes, in and out, without its socket: takes the bytes that arrive, hands out whole
// requests, and takes their answers, one at a time and in order. Internal to server/http. Not
// thread-safe.
class Connection {
 public:
  // The references must outlive it.
  Connection(std::string remote, const HttpOptions& options, const HttpServer::Admit& admit,
             ByteBudgets& budgets);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  ConnectionState state() const { return state_; }
  // Whether nothing more can come of it.
  bool finished() const { return finished_; }
  // Whether it waits for a request of which no byte has arrived. Empty lines before it, or the
  // first half of one, don't count.
  bool is_idle() const { return state_ == ConnectionState::kHead && (in_.empty() || in_ == "\r"); }
  // Since when it is in this state; in a head, since its first byte.
  Clock::time_point since() const { return since_; }
  // When OnTimeout is to be called.
  Clock::time_point deadline() const { return deadline_; }
  void OnTimeout();

  bool wants_input() const;
  void Receive(std::string_view bytes);
  void ReceiveEnd();                 // the client sends no more
  void Fail() { finished_ = true; }  // the client takes no more

  // Whether a request has arrived, or is to be refused: it is taken once, and answered with
  // TakeAnswer.
  bool has_request() const { return ready_; }
  bool is_urgent() const { return head_.is_urgent; }
  ReceivedRequest TakeRequest();
  void TakeAnswer(const SentResponse& answer);

  // What is to be written now; Sent() says how much of it was.
  std::string_view out() const { return std::string_view(out_).substr(sent_); }
  void Sent(size_t bytes);

 private:
  void Advance();
  void SkipEmptyLines();
  void ReadHead();
  void StartBody();
  void ReadBody();
  void HoldBody(size_t before);
  void Refuse(const MapError& error);
  void FailBody(const MapError& error);
  MapError TooLarge() const;
  void Settle();
  void Enter(ConnectionState state);
  void TimeHead();
  void WaitForBody();
  void ReturnBody();

  const HttpOptions& options_;
  const HttpServer::Admit& admit_;
  ByteBudgets& budgets_;
  const std::string remote_;
  ConnectionState state_ = ConnectionState::kHead;
  Clock::time_point since_;
  Clock::time_point deadline_;
  bool finished_ = false;

  std::string in_;
  int empty_lines_ = 0;  // before the request
  bool input_ended_ = false;
  HeadScanner scanner_;
  RequestHead head_;
  ChunkedBody chunks_;
  std::string body_;
  int64_t received_ = 0;  // of the body
  int64_t held_ = 0;      // of the budget
  std::optional<MapError> body_error_;
  bool ready_ = false;
  bool close_ = false;  // after the answer

  std::string out_;
  size_t sent_ = 0;
  int64_t answer_bytes_ = 0;  // of the budget
  int64_t discarded_ = 0;     // of what came behind the last request
};

}  // namespace waystone
