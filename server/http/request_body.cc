// SPDX-License-Identifier: Apache-2.0
#include "server/http/request_body.h"

#include <chrono>
#include <utility>

#include "core/base/error.h"

namespace waystone {
namespace {

// How much of a body that nobody wants is read, as a multiple of the limit, so that the client gets
// to read the answer: closing with unread bytes would reset the connection under it.
constexpr int kDrainFactor = 2;

}  // namespace

RequestBody::RequestBody(BodyReader reader, const HttpOptions& options, BodyBudget& budget)
    : reader_(std::move(reader)),
      budget_(budget),
      limit_(options.max_body_bytes),
      end_(Clock::now() + std::chrono::seconds(options.body_timeout_s)) {}

RequestBody::~RequestBody() { budget_.Return(taken_); }

template <class Take>
bool RequestBody::ReadInto(const Take& take) {
  started_ = true;
  complete_ = reader_([&](const char* data, size_t size) {
    count_ += static_cast<int64_t>(size);
    late_ |= Clock::now() > end_;
    if (late_ || crowded_) return false;
    if (count_ <= limit_) take(data, size);
    return count_ <= kDrainFactor * limit_;
  });
  return complete_;
}

std::string RequestBody::Read() {
  std::string bytes;
  const bool complete = ReadInto([&](const char* data, size_t size) {
    taken_ += static_cast<int64_t>(size);
    crowded_ |= !budget_.Take(static_cast<int64_t>(size));
    if (!crowded_) bytes.append(data, size);
  });
  if (late_) {
    throw MapError(ErrorCode::kTooSlow,
                   "the request body was not received in time; send a smaller "
                   "image or use a faster connection");
  }
  if (crowded_) {
    throw MapError(ErrorCode::kBusy, "too many request bodies in progress; try again");
  }
  if (count_ > limit_) {
    throw MapError(
        ErrorCode::kPayloadTooLarge,
        "the request body exceeds " + std::to_string(limit_) + " bytes; send a smaller image");
  }
  if (!complete)
    throw MapError(ErrorCode::kBadRequest, "the request body is shorter than its Content-Length");
  return bytes;
}

bool RequestBody::Drain() {
  if (!started_) complete_ = ReadInto([](const char*, size_t) {});
  return complete_;
}

}  // namespace waystone
