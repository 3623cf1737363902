// SPDX-License-Identifier: Apache-2.0
#include "server/http/connection.h"

#include <algorithm>
#include <utility>

namespace waystone {
namespace {

// How much of an unwanted body is read, as a multiple of the limit: of one in chunks so that the
// connection can be used again, of others so that the client gets to reading the answer.
constexpr int kDrainFactor = 2;
// Before a request: some clients send one after a body.
constexpr int kMaxEmptyLines = 8;
constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";

Clock::time_point After(Clock::time_point start, int seconds) {
  return start + std::chrono::seconds(seconds);
}

}  // namespace

Connection::Connection(std::string remote, const HttpOptions& options,
                       const HttpServer::Admit& admit, ByteBudgets& budgets)
    : options_(options), admit_(admit), budgets_(budgets), remote_(std::move(remote)) {
  Enter(ConnectionState::kHead);
}

Connection::~Connection() {
  ReturnBody();
  budgets_.answers.Return(answer_bytes_);
}

void Connection::ReturnBody() { budgets_.bodies.Return(std::exchange(held_, 0)); }

void Connection::Enter(ConnectionState state) {
  state_ = state;
  since_ = Clock::now();
  switch (state) {
    case ConnectionState::kHead:
      deadline_ = After(since_, options_.keep_alive_s);
      break;
    case ConnectionState::kBody:
      deadline_ = After(since_, std::min(options_.read_timeout_s, options_.body_timeout_s));
      break;
    case ConnectionState::kAnswer:
      deadline_ = Clock::time_point::max();
      break;
    case ConnectionState::kWriting:
      deadline_ = After(since_, options_.write_timeout_s);
      break;
    case ConnectionState::kClosing:
      deadline_ = After(since_, options_.read_timeout_s);
      break;
  }
}

// A head's time runs from its first byte.
void Connection::TimeHead() {
  if (state_ != ConnectionState::kHead || is_idle()) return;
  since_ = Clock::now();
  deadline_ = After(since_, options_.head_timeout_s);
}

// For more of it, wanted or not.
void Connection::WaitForBody() {
  deadline_ = std::min(After(Clock::now(), options_.read_timeout_s),
                       After(since_, options_.body_timeout_s));
}

void Connection::OnTimeout() {
  if (state_ == ConnectionState::kHead && !is_idle()) {
    Refuse(MapError(ErrorCode::kTooSlow, "the request was not received in time"));
  } else if (state_ == ConnectionState::kBody) {
    FailBody({ErrorCode::kTooSlow,
              "the request body was not received in time; send a smaller image or use a faster "
              "connection"});
  } else {
    finished_ = true;
  }
}

bool Connection::wants_input() const {
  return !input_ended_ && !ready_ && state_ != ConnectionState::kAnswer &&
         state_ != ConnectionState::kWriting;
}

void Connection::Receive(std::string_view bytes) {
  if (state_ == ConnectionState::kClosing) {
    discarded_ += static_cast<int64_t>(bytes.size());
    finished_ |= discarded_ > kDrainFactor * options_.max_body_bytes;
    return WaitForBody();
  }
  const bool was_idle = is_idle();
  in_ += bytes;
  if (state_ == ConnectionState::kBody) WaitForBody();
  Advance();
  if (was_idle) TimeHead();
}

void Connection::ReceiveEnd() {
  input_ended_ = true;
  const bool waits_for_client =
      state_ == ConnectionState::kHead || state_ == ConnectionState::kClosing;
  if (waits_for_client && !ready_) finished_ = true;
  if (state_ == ConnectionState::kBody) {
    FailBody({ErrorCode::kBadRequest, "the connection ended before the request body did"});
  }
}

void Connection::Advance() {
  if (state_ == ConnectionState::kHead) ReadHead();
  if (state_ == ConnectionState::kBody) ReadBody();
}

void Connection::SkipEmptyLines() {
  size_t skipped = 0;
  for (; std::string_view(in_).substr(skipped).starts_with("\r\n"); skipped += 2) {
    if (++empty_lines_ <= kMaxEmptyLines) continue;
    throw MapError(ErrorCode::kBadRequest, "more than " + std::to_string(kMaxEmptyLines) +
                                               " empty lines before the request; send its request "
                                               "line first");
  }
  if (skipped == 0) return;
  in_.erase(0, skipped);
  scanner_ = {};
}

void Connection::ReadHead() {
  try {
    SkipEmptyLines();
    const std::optional<size_t> size = scanner_.Scan(in_);
    if (!size) return;
    head_ = ParseRequestHead(std::string_view(in_).substr(0, *size));
    in_.erase(0, *size);
    scanner_ = {};
  } catch (const MapError& error) {
    return Refuse(error);
  }
  if (head_.refusal) return Refuse(MapError(*head_.refusal));
  Enter(ConnectionState::kBody);
  StartBody();
}

void Connection::StartBody() {
  if (!head_.has_body()) return Settle();
  if (!admit_(head_.authorization)) {
    return FailBody({ErrorCode::kUnauthorized, "the request body was not read"});
  }
  if (head_.body_bytes > options_.max_body_bytes) return FailBody(TooLarge());
  if (head_.expects_continue) out_ += kContinue;
}

void Connection::ReadBody() {
  const size_t before = body_.size();
  bool complete = false;
  if (head_.chunked) {
    try {
      in_.erase(0, chunks_.Take(in_, body_));
    } catch (const MapError& error) {
      return FailBody({error.code(), error.what()});
    }
    complete = chunks_.complete();
    received_ += static_cast<int64_t>(body_.size() - before);
  } else {
    const auto left = static_cast<size_t>(head_.body_bytes - received_);
    const size_t taken = std::min(in_.size(), left);
    body_.append(in_, 0, taken);
    in_.erase(0, taken);
    received_ += static_cast<int64_t>(taken);
    complete = received_ == head_.body_bytes;
  }
  HoldBody(before);
  if (complete && !ready_) Settle();
}

// Counts the body's new bytes, and drops the body when it gets too large.
void Connection::HoldBody(size_t before) {
  const auto grown = static_cast<int64_t>(body_.size() - before);
  if (received_ > options_.max_body_bytes) {
    body_ = {};
    ReturnBody();
    body_error_ = TooLarge();
    if (received_ > kDrainFactor * options_.max_body_bytes) {
      close_ = true;
      Settle();
    }
    return;
  }
  held_ += grown;
  if (!budgets_.bodies.Take(grown)) {
    FailBody({ErrorCode::kBusy, "too many request bodies in progress; try again"});
  }
}

MapError Connection::TooLarge() const {
  return {ErrorCode::kPayloadTooLarge, "the request body exceeds " +
                                           std::to_string(options_.max_body_bytes) +
                                           " bytes; send a smaller image"};
}

void Connection::FailBody(const MapError& error) {
  body_ = {};
  ReturnBody();
  body_error_ = error;
  close_ = true;
  Settle();
}

// Nobody knows where the next request begins, so there is none.
void Connection::Refuse(const MapError& error) {
  head_.refusal = error;
  close_ = true;
  Settle();
}

void Connection::Settle() {
  ready_ = true;
  Enter(ConnectionState::kAnswer);
}

ReceivedRequest Connection::TakeRequest() {
  constexpr const char* kAnyHead = "GET / HTTP/1.1\r\n\r\n";  // the answer doesn't depend on it
  ready_ = false;
  return {.head = head_.refusal ? kAnyHead : std::exchange(head_.text, {}),
          .method = std::exchange(head_.method, {}),
          .target = std::exchange(head_.target, {}),
          .host = std::exchange(head_.host, {}),
          .headers = head_.refusal ? HttpHeaders() : std::exchange(head_.headers, {}),
          .body = std::exchange(body_, {}),
          .remote = remote_,
          .received = Clock::now(),
          .close = close_ || head_.close || input_ended_,
          .refusal = head_.refusal,
          .body_error = std::exchange(body_error_, {})};
}

void Connection::TakeAnswer(const SentResponse& answer) {
  ReturnBody();
  close_ |= answer.close;
  out_ += answer.bytes;
  answer_bytes_ = static_cast<int64_t>(answer.bytes.size());
  budgets_.answers.Take(answer_bytes_);
  Enter(ConnectionState::kWriting);
  Sent(0);
}

void Connection::Sent(size_t bytes) {
  sent_ += bytes;
  if (state_ == ConnectionState::kWriting && bytes > 0) {
    deadline_ = std::min(After(Clock::now(), options_.write_timeout_s),
                         After(since_, options_.answer_timeout_s));
  }
  if (sent_ < out_.size()) return;
  out_ = {};
  sent_ = 0;
  if (state_ != ConnectionState::kWriting) return;
  budgets_.answers.Return(std::exchange(answer_bytes_, 0));
  if (close_) return Enter(ConnectionState::kClosing);
  head_ = {};
  chunks_ = {};
  received_ = 0;
  empty_lines_ = 0;
  Enter(ConnectionState::kHead);
  Advance();
  TimeHead();
  if (input_ended_ && !ready_) finished_ = true;
}

}  // namespace waystone
