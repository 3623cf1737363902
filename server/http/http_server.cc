// SPDX-License-Identifier: Apache-2.0
#include "server/http/http_server.h"

#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <new>
#include <utility>

#include "core/base/error.h"
#include "server/http/connection_loop.h"
#include "server/http/file_descriptor.h"
#include "server/http/http_engine.h"
#include "server/http/server_names.h"

namespace waystone {
namespace {

// Holds none where it can't be opened; errno says why.
FileDescriptor OpenListener(const addrinfo& address, int backlog) {
  FileDescriptor listener(socket(address.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!listener.is_open()) return listener;
  // Not SO_REUSEPORT, with which a second server would silently share the port.
  const int on = 1;
  setsockopt(listener.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  const bool listens = bind(listener.get(), address.ai_addr, address.ai_addrlen) == 0 &&
                       listen(listener.get(), backlog) == 0;
  return listens ? std::move(listener) : FileDescriptor(-1);
}

// The listening socket. Throws MapError(kBadOptions).
FileDescriptor Bind(const HttpOptions& options) {
  const std::string port = std::to_string(options.port);
  const auto fail = [&](const std::string& cause) {
    throw MapError(ErrorCode::kBadOptions, "can't listen on " + options.host + ":" + port + " (" +
                                               cause + "); choose another --port or --host");
  };
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const char* host = options.host.empty() ? nullptr : options.host.c_str();
  if (const int error = getaddrinfo(host, port.c_str(), &hints, &found); error != 0) {
    if (error == EAI_MEMORY) throw std::bad_alloc();
    fail(gai_strerror(error));
  }
  FileDescriptor listener(-1);
  for (const addrinfo* it = found; it != nullptr && !listener.is_open(); it = it->ai_next) {
    listener = OpenListener(*it, options.backlog);
  }
  const int cause = errno;
  freeaddrinfo(found);
  if (!listener.is_open()) fail(std::strerror(cause));
  return listener;
}

int PortOf(const FileDescriptor& listener) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  getsockname(listener.get(), reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.ss_family == AF_INET6
                   ? reinterpret_cast<const sockaddr_in6&>(address).sin6_port
                   : reinterpret_cast<const sockaddr_in&>(address).sin_port);
}

}  // namespace

void HttpOptions::Check() const {
  CheckFields("http", *this);
  const auto require = [](bool holds, const std::string& message) {
    if (!holds) throw MapError(ErrorCode::kBadOptions, message);
  };
  require(IsLoopback(host) || has_tokens || insecure,
          host +
              " can be reached by other machines, and no authentication is required; use "
              "--token-file, --host 127.0.0.1 behind a proxy, or --insecure");
  require(max_bodies_bytes >= max_body_bytes,
          "http.max_bodies_bytes must be at least http.max_body_bytes");
}

class HttpServer::Impl {
 public:
  Impl(const HttpOptions& options, FileDescriptor listener, Dispatch dispatch, Admit admit)
      : options_(options),
        port_(PortOf(listener)),
        engine_(std::move(dispatch), port_, options.keep_alive_s),
        loop_(std::move(listener), options_, std::move(admit),
              [this](ReceivedRequest request) { return engine_.Answer(std::move(request)); }) {}

  const std::string& host() const { return options_.host; }
  int port() const { return port_; }
  ConnectionLoop& loop() { return loop_; }

 private:
  const HttpOptions options_;
  const int port_;
  HttpEngine engine_;
  ConnectionLoop loop_;
};

HttpServer::HttpServer(const HttpOptions& options, Dispatch dispatch, Admit admit) {
  options.Check();
  impl_ = std::make_unique<Impl>(options, Bind(options), std::move(dispatch), std::move(admit));
}
HttpServer::~HttpServer() = default;

int HttpServer::port() const { return impl_->port(); }

std::string HttpServer::url() const {
  const bool v6 = impl_->host().find(':') != std::string::npos;
  return "http://" + (v6 ? "[" + impl_->host() + "]" : impl_->host()) + ":" +
         std::to_string(impl_->port());
}

void HttpServer::Start() { impl_->loop().Start(); }
void HttpServer::Drain() { impl_->loop().Drain(); }
void HttpServer::Stop(const std::function<void()>& on_late) { impl_->loop().Stop(on_late); }

}  // namespace waystone
