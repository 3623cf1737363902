// SPDX-License-Identifier: Apache-2.0
#include "server/http/http_server.h"

#include <httplib.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>
#include <utility>

#include "core/base/error.h"
#include "server/http/problem.h"

namespace waystone {
namespace {

// Requests on one connection. The library's default of 5 would close good connections.
constexpr int kRequestsPerConnection = 1'000'000;
// How much of a body that nobody wants is read, as a multiple of the limit, so that the client gets
// to read the answer: closing with unread bytes would reset the connection under it.
constexpr int kDrainFactor = 2;

bool IsLoopback(const std::string& host) {
  return host == "localhost" || host == "::1" || host.starts_with("127.");
}

// The body of one request, read at most once.
class Body {
 public:
  Body(const httplib::ContentReader& reader, int64_t limit) : reader_(reader), limit_(limit) {}

  std::string Read() {
    std::string bytes;
    bool complete = ReadInto([&](const char* data, size_t size) { bytes.append(data, size); });
    if (count_ > limit_) {
      throw MapError(ErrorCode::kPayloadTooLarge,
                     "the body is over " + std::to_string(limit_) + " bytes; send a smaller image");
    }
    if (!complete) throw MapError(ErrorCode::kBadRequest, "the body ended before its length");
    return bytes;
  }

  // Reads what is left. Returns whether the connection is at the end of the body, and so at the
  // start of the next request.
  bool Drain() {
    if (!started_) complete_ = ReadInto([](const char*, size_t) {});
    return complete_;
  }

 private:
  template <class Take>
  bool ReadInto(const Take& take) {
    started_ = true;
    complete_ = reader_([&](const char* data, size_t size) {
      count_ += static_cast<int64_t>(size);
      if (count_ <= limit_) take(data, size);
      return count_ <= kDrainFactor * limit_;
    });
    return complete_;
  }

  const httplib::ContentReader& reader_;
  int64_t limit_;
  int64_t count_ = 0;
  bool started_ = false;
  bool complete_ = false;
};

HttpRequest ToRequest(const httplib::Request& in) {
  HttpRequest request;
  request.method = in.method;
  request.path = in.path;
  for (const auto& [name, value] : in.params) request.query.emplace(name, value);
  request.header = [&in](const std::string& name) -> std::optional<std::string> {
    if (!in.has_header(name)) return std::nullopt;
    return in.get_header_value(name);
  };
  request.read_body = [] { return std::string(); };
  return request;
}

void Fill(const HttpResponse& from, httplib::Response& to) {
  to.status = from.status;
  for (const auto& [name, value] : from.headers) to.set_header(name, value);
  if (from.status != 304) to.set_content(from.body, from.content_type);
}

// Answers and closes the connection, whose next bytes can't be trusted to start a request. The
// library closes when a provider of content gives up, so this one gives up after the last byte.
void FillAndClose(const HttpResponse& from, httplib::Response& to) {
  to.status = from.status;
  for (const auto& [name, value] : from.headers) to.set_header(name, value);
  to.set_header("Connection", "close");
  to.set_content_provider(from.body.size(), from.content_type,
                          [body = from.body](size_t, size_t, httplib::DataSink& sink) {
                            sink.write(body.data(), body.size());
                            return false;
                          });
}

// Takes out of a request what the library would act on by itself: ranges, which it applies to
// errors too and copies a body for as often as it is asked; and compression, for which it takes the
// slowest setting. A server may leave both undone. The request is the library's own variable, not a
// constant.
void LeaveUndone(const httplib::Request& request) {
  auto& own = const_cast<httplib::Request&>(request);
  own.ranges.clear();
  own.headers.erase("Accept-Encoding");
}

bool IsNumber(const std::string& text) {
  return !text.empty() && text.size() <= 18 &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

// What is refused by its headers alone, before a byte of the body is read. Nothing when sound.
std::optional<HttpResponse> Refusal(const httplib::Request& request) {
  const auto refuse = [](ErrorCode code, const std::string& detail) {
    return std::optional<HttpResponse>(ProblemResponse(code, detail));
  };
  const size_t lengths = request.get_header_value_count("Content-Length");
  const bool chunked = request.has_header("Transfer-Encoding");
  if (lengths > 1 || (lengths == 1 && chunked)) {
    return refuse(ErrorCode::kBadRequest, "the body's length is given twice");
  }
  if (lengths == 1 && !IsNumber(request.get_header_value("Content-Length"))) {
    return refuse(ErrorCode::kBadRequest, "Content-Length is not a number");
  }
  if (request.has_header("Content-Encoding")) {
    return refuse(ErrorCode::kUnsupportedMedia,
                  "encoded bodies are not taken; send the image without Content-Encoding");
  }
  const bool has_body =
      chunked || (lengths == 1 && request.get_header_value("Content-Length") != "0");
  if (has_body && request.method != "POST") {
    return refuse(ErrorCode::kBadRequest, request.method + " takes no body");
  }
  return std::nullopt;
}

}  // namespace

void HttpOptions::Check() const {
  const auto require = [](bool holds, const std::string& message) {
    if (!holds) throw MapError(ErrorCode::kBadOptions, message);
  };
  require(port >= 0 && port <= 65535,
          "port " + std::to_string(port) + " is not one; give 0 (any) to 65535");
  require(IsLoopback(host) || insecure,
          host +
              " can be reached by other machines, and nobody has to show who they are; "
              "use --host 127.0.0.1 behind a proxy, or add --insecure");
  require(max_body_bytes > 0, "max_body_bytes must be above 0");
  require(connection_threads >= 1 && connection_threads <= 10'000,
          "connection_threads must be 1 to 10000");
  require(backlog >= 1 && keep_alive_s >= 1 && read_timeout_s >= 1 && write_timeout_s >= 1,
          "backlog and timeouts must be above 0");
}

class HttpServer::Impl {
 public:
  Impl(const HttpOptions& options, Dispatch dispatch)
      : options_(options), dispatch_(std::move(dispatch)) {
    options_.Check();
    Configure();
    AddRoutes();
    Bind();
  }
  ~Impl() { Stop(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  int port() const { return port_; }
  const std::string& host() const { return options_.host; }

  void Start() {
    thread_ = std::thread([this] {
      server_.listen_after_bind();
      ended_ = true;
    });
    while (!server_.is_running() && !ended_)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  void Stop() {
    if (!thread_.joinable()) return;
    server_.stop();
    thread_.join();
  }

 private:
  void Configure() {
    server_.set_tcp_nodelay(true);
    server_.set_keep_alive_max_count(kRequestsPerConnection);
    server_.set_keep_alive_timeout(options_.keep_alive_s);
    server_.set_read_timeout(options_.read_timeout_s);
    server_.set_write_timeout(options_.write_timeout_s);
    server_.set_default_headers({{"X-Content-Type-Options", "nosniff"}});
    server_.new_task_queue = [n = options_.connection_threads] {
      return new httplib::ThreadPool(static_cast<size_t>(n));
    };
    // Not the library's SO_REUSEPORT, with which a second server would silently share the port.
    server_.set_socket_options([this](socket_t socket) {
      socket_ = socket;
      const int on = 1;
      setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
    });
  }

  void AddRoutes() {
    using Response = httplib::Server::HandlerResponse;
    server_.set_pre_routing_handler([this](const httplib::Request& in, httplib::Response& out) {
      LeaveUndone(in);
      std::optional<HttpResponse> refusal = Refusal(in);
      // Methods other than these never reach a route below: their bodies stay unread.
      if (!refusal && in.method != "GET" && in.method != "HEAD" && in.method != "POST") {
        refusal = dispatch_(ToRequest(in));
      }
      if (!refusal) return Response::Unhandled;
      FillAndClose(*refusal, out);
      return Response::Handled;
    });
    server_.Get(".*", [this](const httplib::Request& in, httplib::Response& out) {
      Fill(dispatch_(ToRequest(in)), out);
    });
    server_.Post(".*", [this](const httplib::Request& in, httplib::Response& out,
                              const httplib::ContentReader& reader) { Post(in, out, reader); });
    const httplib::Server::HandlerWithResponse name_error = [](const httplib::Request&,
                                                               httplib::Response& out) {
      if (!out.body.empty() || out.content_length_ > 0) return Response::Unhandled;
      Fill(ProblemResponseForStatus(out.status), out);
      return Response::Handled;
    };
    server_.set_error_handler(name_error);
    // Without it the library would send the exception's text as a header.
    server_.set_exception_handler(
        [](const httplib::Request&, httplib::Response& out, const std::exception_ptr&) {
          Fill(ProblemResponse(ErrorCode::kInternal, "the server failed"), out);
        });
  }

  void Post(const httplib::Request& in, httplib::Response& out,
            const httplib::ContentReader& reader) const {
    Body body(reader, options_.max_body_bytes);
    HttpRequest request = ToRequest(in);
    request.read_body = [&body] { return body.Read(); };
    const HttpResponse response = dispatch_(request);
    const bool at_end = body.Drain();
    out.status = -1;  // the reader may have set one of its own
    if (at_end) {
      Fill(response, out);
    } else {
      FillAndClose(response, out);
    }
  }

  void Bind() {
    const bool any = options_.port == 0;
    port_ = any ? server_.bind_to_any_port(options_.host) : options_.port;
    const bool bound = any ? port_ > 0 : server_.bind_to_port(options_.host, options_.port);
    if (!bound) {
      throw MapError(ErrorCode::kBadOptions,
                     "can't listen on " + options_.host + ":" + std::to_string(options_.port) +
                         " (" + std::strerror(errno) + "); use another --port or --host");
    }
    // The library's own backlog is 5: a burst of connections would wait a second for its retry.
    ::listen(socket_, options_.backlog);
  }

  HttpOptions options_;
  Dispatch dispatch_;
  httplib::Server server_;
  socket_t socket_ = -1;
  int port_ = 0;
  std::thread thread_;
  std::atomic<bool> ended_ = false;
};

HttpServer::HttpServer(const HttpOptions& options, Dispatch dispatch)
    : impl_(std::make_unique<Impl>(options, std::move(dispatch))) {}
HttpServer::~HttpServer() = default;

int HttpServer::port() const { return impl_->port(); }

std::string HttpServer::url() const {
  const bool v6 = impl_->host().find(':') != std::string::npos;
  return "http://" + (v6 ? "[" + impl_->host() + "]" : impl_->host()) + ":" +
         std::to_string(impl_->port());
}

void HttpServer::Start() { impl_->Start(); }
void HttpServer::Stop() { impl_->Stop(); }

}  // namespace waystone
