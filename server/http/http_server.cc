// SPDX-License-Identifier: Apache-2.0
#include "server/http/http_server.h"

#include <httplib.h>
#include <strings.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

#include "core/base/error.h"
#include "server/http/problem.h"
#include "server/http/request_body.h"

namespace waystone {
namespace {

// Requests on one connection. The library's default of 5 would close good connections.
constexpr int kRequestsPerConnection = 1'000'000;

bool IsLoopback(const std::string& host) {
  return host == "localhost" || host == "::1" || host.starts_with("127.");
}

// A path may have a line break in it, which the usual dot doesn't stand for.
constexpr const char* kAnyPath = "[\\s\\S]*";

// The library's pool without its endless queue: connections beyond the threads wait in the kernel,
// which holds as many as the backlog says.
class BoundedPool : public httplib::TaskQueue {
 public:
  explicit BoundedPool(int threads) : free_(threads), pool_(static_cast<size_t>(threads)) {}

  // The library's later versions want to hear whether it was taken, earlier ones don't.
  using Taken = decltype(std::declval<httplib::TaskQueue&>().enqueue(std::function<void()>()));
  Taken enqueue(std::function<void()> connection) override {
    std::unique_lock lock(mutex_);
    freed_.wait(lock, [this] { return free_ > 0; });
    --free_;
    lock.unlock();
    pool_.enqueue([this, connection = std::move(connection)] {
      connection();
      {
        const std::lock_guard guard(mutex_);
        ++free_;
      }
      freed_.notify_one();
    });
    return static_cast<Taken>(true);
  }

  void shutdown() override { pool_.shutdown(); }

 private:
  std::mutex mutex_;
  std::condition_variable freed_;
  int free_;
  httplib::ThreadPool pool_;
};

// Headers that are set aside: the library would compress by itself, slowly, and parse forms,
// without a bound. No client's header begins as theirs do meanwhile.
const std::array<std::string, 2> kHidden = {"Accept-Encoding", "Content-Type"};
const std::string kAside = "\t";

bool IsSetAside(const std::string& name) {
  return std::any_of(kHidden.begin(), kHidden.end(), [&](const std::string& hidden) {
    return strcasecmp(name.c_str(), hidden.c_str()) == 0;
  });
}

HttpRequest ToRequest(const httplib::Request& in) {
  HttpRequest request;
  request.method = in.method;
  request.path = in.path;
  request.remote = in.remote_addr;
  for (const auto& [name, value] : in.params) request.query.emplace(name, value);
  request.header = [&in](const std::string& name) -> std::optional<std::string> {
    const std::string key = IsSetAside(name) ? kAside + name : name;
    if (!in.has_header(key)) return std::nullopt;
    return in.get_header_value(key);
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
// errors too and copies a body for as often as it is asked; compression, for which it takes the
// slowest setting; and forms. A server may leave the first two undone, and ours reads forms itself.
// Handlers still see the headers that were set aside. The request is the library's own variable,
// not a constant.
void LeaveUndone(const httplib::Request& request) {
  auto& own = const_cast<httplib::Request&>(request);
  own.ranges.clear();
  for (const std::string& name : kHidden) {
    const std::string aside = kAside + name;
    own.headers.erase(aside);
    if (!request.has_header(name)) continue;
    own.headers.emplace(aside, request.get_header_value(name));
    own.headers.erase(name);
  }
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
    return refuse(ErrorCode::kBadRequest, "the length of the body is given twice");
  }
  if (lengths == 1 && !IsNumber(request.get_header_value("Content-Length"))) {
    return refuse(ErrorCode::kBadRequest, "Content-Length is not a number");
  }
  if (request.has_header("Content-Encoding")) {
    return refuse(ErrorCode::kUnsupportedMedia,
                  "encoded bodies are not supported; send the image without Content-Encoding");
  }
  const bool has_body =
      chunked || (lengths == 1 && request.get_header_value("Content-Length") != "0");
  if (has_body && request.method != "POST") {
    return refuse(ErrorCode::kBadRequest, request.method + " requests must not have a body");
  }
  return std::nullopt;
}

}  // namespace

void HttpOptions::Check() const {
  const auto require = [](bool holds, const std::string& message) {
    if (!holds) throw MapError(ErrorCode::kBadOptions, message);
  };
  require(port >= 0 && port <= 65535,
          "port " + std::to_string(port) + " is invalid; it must be between 0 (any) and 65535");
  require(IsLoopback(host) || has_tokens || insecure,
          host +
              " is reachable from other machines and authentication is off; use "
              "--token-file, --host 127.0.0.1 behind a proxy, or --insecure");
  require(max_body_bytes > 0 && max_bodies_bytes >= max_body_bytes,
          "max_body_bytes must be positive and max_bodies_bytes at least as large");
  require(connection_threads >= 1 && connection_threads <= 10'000,
          "connection_threads must be between 1 and 10000");
  require(backlog >= 1 && keep_alive_s >= 1 && read_timeout_s >= 1 && write_timeout_s >= 1 &&
              body_timeout_s >= 1,
          "backlog and timeouts must be positive");
}

class HttpServer::Impl {
 public:
  Impl(const HttpOptions& options, Dispatch dispatch)
      : options_(options), budget_(options.max_bodies_bytes), dispatch_(std::move(dispatch)) {
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
    server_.new_task_queue = [n = options_.connection_threads] { return new BoundedPool(n); };
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
    server_.Get(kAnyPath, [this](const httplib::Request& in, httplib::Response& out) {
      Fill(dispatch_(ToRequest(in)), out);
    });
    server_.Post(kAnyPath, [this](const httplib::Request& in, httplib::Response& out,
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
          Fill(ProblemResponse(ErrorCode::kInternal, "internal server error"), out);
        });
  }

  void Post(const httplib::Request& in, httplib::Response& out,
            const httplib::ContentReader& reader) {
    RequestBody body([&reader](const BodyReceiver& receive) { return reader(receive); }, options_,
                     budget_);
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
                         " (" + std::strerror(errno) + "); choose another --port or --host");
    }
    // The library's own backlog is 5: a burst of connections would wait a second for its retry.
    ::listen(socket_, options_.backlog);
  }

  HttpOptions options_;
  BodyBudget budget_;
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
