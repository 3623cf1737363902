// SPDX-License-Identifier: Apache-2.0
#include "server/http/http_engine.h"

#include <httplib.h>
#include <strings.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <ctime>
#include <exception>
#include <new>
#include <string_view>
#include <utility>

#include "server/http/problem.h"
#include "server/http/request_target.h"

namespace waystone {
namespace {

// The request that this thread answers; the library has no place to put it.
thread_local ReceivedRequest* current_request = nullptr;

// What the library reads a head from and writes an answer to.
class MemoryStream : public httplib::Stream {
 public:
  MemoryStream(const std::string& in, const std::string& remote) : in_(in), remote_(remote) {}

  // What later versions of the library declare isn't in earlier ones, and the other way round.
  // NOLINTBEGIN(modernize-use-override)
  virtual bool is_readable() const { return true; }
  virtual bool wait_readable() const { return true; }
  virtual bool is_writable() const { return true; }
  virtual bool wait_writable() const { return true; }
  virtual time_t duration() const { return 0; }
  // NOLINTEND(modernize-use-override)

  using Stream::write;
  ssize_t read(char* data, size_t size) override {
    const size_t count = std::min(size, in_.size() - at_);
    std::memcpy(data, in_.data() + at_, count);
    at_ += count;
    return static_cast<ssize_t>(count);
  }
  ssize_t write(const char* data, size_t size) override {
    out_.append(data, size);
    return static_cast<ssize_t>(size);
  }
  void get_remote_ip_and_port(std::string& ip, int& port) const override {
    ip = remote_;
    port = 0;
  }
  void get_local_ip_and_port(std::string& ip, int& port) const override {
    ip.clear();
    port = 0;
  }
  socket_t socket() const override { return INVALID_SOCKET; }

  std::string& out() { return out_; }

 private:
  const std::string& in_;
  const std::string& remote_;
  size_t at_ = 0;
  std::string out_;
};

// The library gets the request line of some request of that kind; the real one is parsed without
// it.
std::string HeadForLibrary(const ReceivedRequest& request) {
  const size_t line_end = request.head.find("\r\n");
  const size_t version = request.head.rfind(' ', line_end);
  return (request.method == "HEAD" ? "HEAD /" : "GET /") + request.head.substr(version);
}

HttpRequest ToRequest(int port, ReceivedRequest& received) {
  HttpRequest request;
  request.method = received.method;
  request.path = PathOf(received.target);
  request.remote = received.remote;
  request.port = port;
  request.received = received.received;
  request.refusal = received.refusal;
  try {
    request.query = QueryOf(received.target);
  } catch (const MapError& error) {
    if (!request.refusal) request.refusal = error;
  }
  // As they came: the library decodes percent signs and drops empty headers.
  request.header = [&received](const std::string& name) -> std::optional<std::string> {
    if (strcasecmp(name.c_str(), "Host") == 0) return received.host;
    std::optional<std::string> joined;
    for (const auto& [key, value] : received.headers) {
      if (strcasecmp(key.c_str(), name.c_str()) != 0) continue;
      joined = joined ? *joined + ", " + value : value;
    }
    return joined;
  };
  request.read_body = [&received] {
    if (const auto& error = received.body_error) throw MapError(error->code(), error->what());
    return std::move(received.body);
  };
  return request;
}

// "Sun, 06 Nov 1994 08:49:37 GMT" (RFC 9110, section 5.6.7).
std::string DateNow() {
  const time_t now = std::time(nullptr);
  tm parts = {};
  gmtime_r(&now, &parts);
  std::array<char, 40> text{};
  std::strftime(text.data(), text.size(), "%a, %d %b %Y %H:%M:%S GMT", &parts);  // "C" locale
  return text.data();
}

void Fill(const HttpResponse& from, httplib::Response& to) {
  to.status = from.status;
  to.set_header("Date", DateNow());
  for (const auto& [name, value] : from.headers) to.set_header(name, value);
  if (from.status != 304) to.set_content(from.body, from.content_type);
}

HttpResponse ProblemOf(const std::exception_ptr& thrown) {
  try {
    std::rethrow_exception(thrown);
  } catch (const std::bad_alloc&) {
    return OutOfMemoryResponse();
  } catch (...) {
    return ProblemResponse(ErrorCode::kInternal, "internal server error");
  }
}

// The library says in answers to HEAD that ranges are served, and in a 304 that its content, which
// isn't sent, is empty (RFC 9110, sections 14.3 and 8.6). Of the connection, the head says both
// that it is kept and that it is closed. The head only becomes shorter, so that the body needs no
// other memory.
void CorrectHead(std::string& response, bool close) {
  const size_t end = std::min(response.find("\r\n\r\n"), response.size());
  std::string head = response.substr(0, end);
  const auto drop = [&head](const std::string& line) {
    const size_t at = head.find("\r\n" + line);
    if (at != head.npos) head.erase(at, head.find("\r\n", at + 2) - at);
  };
  drop("Accept-Ranges: bytes");
  if (head.starts_with("HTTP/1.1 304")) drop("Content-Length: 0");
  drop(close ? "Connection: keep-alive" : "Connection: close");
  if (close) drop("Keep-Alive: ");
  response.replace(0, end, head);
}

// The request is the library's own variable, not a constant.
void LeaveUndone(const httplib::Request& request) {
  const_cast<httplib::Request&>(request).headers.erase("Accept-Encoding");
}

}  // namespace

class HttpEngine::Library : public httplib::Server {
 public:
  Library(Dispatch dispatch, int port, int keep_alive_s)
      : dispatch_(std::move(dispatch)), port_(port) {
    set_default_headers({{"X-Content-Type-Options", "nosniff"},
                         {"Connection", "keep-alive"},
                         {"Keep-Alive", "timeout=" + std::to_string(keep_alive_s)}});
    set_pre_routing_handler([this](const httplib::Request& in, httplib::Response& out) {
      LeaveUndone(in);
      Fill(dispatch_(ToRequest(port_, *current_request)), out);
      return HandlerResponse::Handled;
    });
    // Heads that the library can't read.
    set_error_handler(HandlerWithResponse([this](const httplib::Request&, httplib::Response& out) {
      if (!out.body.empty() || out.content_length_ > 0) return HandlerResponse::Unhandled;
      ReceivedRequest& received = *current_request;
      received.close = true;
      received.refusal.emplace(ErrorCode::kBadRequest, "malformed HTTP request");
      Fill(dispatch_(ToRequest(port_, received)), out);
      return HandlerResponse::Handled;
    }));
    // Without it the library would send the exception's text as a header.
    set_exception_handler([](const httplib::Request&, httplib::Response& out,
                             const std::exception_ptr& thrown) { Fill(ProblemOf(thrown), out); });
  }

  // A template, because versions of the library differ in the arguments they take. The library
  // always says that it closes the connection, so that there is one thing to correct.
  template <class Stream>
  bool Process(Stream& stream, const std::string& remote) {
    constexpr bool close = true;
    bool closed = false;
    if constexpr (requires { this->process_request(stream, close, closed, nullptr); }) {
      return this->process_request(stream, close, closed, nullptr);
    } else {
      return this->process_request(stream, remote, 0, "", 0, close, closed, nullptr);
    }
  }

 private:
  Dispatch dispatch_;
  int port_;
};

HttpEngine::HttpEngine(Dispatch dispatch, int port, int keep_alive_s)
    : library_(std::make_unique<Library>(std::move(dispatch), port, keep_alive_s)) {}
HttpEngine::~HttpEngine() = default;

SentResponse HttpEngine::Answer(ReceivedRequest request) {
  const std::string head = HeadForLibrary(request);
  MemoryStream stream(head, request.remote);
  current_request = &request;
  const bool answered = library_->Process(stream, request.remote);
  current_request = nullptr;
  const bool close = request.close || !answered;
  CorrectHead(stream.out(), close);
  return {.bytes = std::move(stream.out()), .close = close};
}

}  // namespace waystone
