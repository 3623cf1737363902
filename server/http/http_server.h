// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <tuple>

#include "core/base/options.h"
#include "server/http/message.h"

namespace waystone {

struct HttpOptions {
  // Address to listen on. Only loopback addresses are taken unless clients must show a token or
  // `insecure` is set.
  std::string host = "127.0.0.1";
  int port = 8080;
  bool insecure = false;
  // The application behind refuses requests without a token.
  bool has_tokens = false;
  int64_t max_body_bytes = 20'000'000;
  int64_t max_bodies_bytes = 400'000'000;
  int connection_threads = 64;
  int backlog = 511;
  int keep_alive_s = 2;
  int read_timeout_s = 5;
  int body_timeout_s = 30;
  int write_timeout_s = 5;

  static constexpr auto Fields() {
    using Self = HttpOptions;
    return std::tuple{
        OptionField{"port", &Self::port, Closed(0, 65535), "", "0 takes any free one."},
        OptionField{"insecure", &Self::insecure, AnyValue(), "",
                    "Listen on an address that other machines reach, although clients need no "
                    "token."},
        OptionField{"max_body_bytes", &Self::max_body_bytes, AtLeast(1), "bytes",
                    "Of a request's body. A photo of 50 megapixels has about 15 MB."},
        OptionField{"max_bodies_bytes", &Self::max_bodies_bytes, AtLeast(1), "bytes",
                    "Of all bodies that are held at once, at least max_body_bytes; the next one "
                    "gets 429."},
        OptionField{"connection_threads", &Self::connection_threads, Closed(1, 10'000), "",
                    "Connections that are held at once, each by a thread, also while it is idle."},
        OptionField{"backlog", &Self::backlog, AtLeast(1), "",
                    "Connections that the kernel keeps ready while all threads are held; it "
                    "refuses more."},
        OptionField{"keep_alive_s", &Self::keep_alive_s, AtLeast(1), "s",
                    "How long an idle connection is kept. Longer saves handshakes and lets slow "
                    "clients hold threads."},
        OptionField{"read_timeout_s", &Self::read_timeout_s, AtLeast(1), "s",
                    "Time without a byte from the client."},
        OptionField{"body_timeout_s", &Self::body_timeout_s, AtLeast(1), "s",
                    "Time in which a whole body must arrive. Longer accepts larger photos over "
                    "slow links and lets slow clients hold threads."},
        OptionField{"write_timeout_s", &Self::write_timeout_s, AtLeast(1), "s",
                    "Time in which the client accepts none of our bytes."}};
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// The HTTP/1.1 transport: sockets, limits and bodies. Knows nothing of maps. Refuses what could be
// read in two ways (bad, repeated or contradicting lengths) and what could cost more than the
// limits say: encoded bodies and bodies over the limit. Ranges and compression are left undone.
// Everything else goes to `dispatch`, from several threads at once; it must not throw.
class HttpServer {
 public:
  using Dispatch = std::function<HttpResponse(const HttpRequest&)>;

  // Binds and listens, without answering yet. Throws MapError(kBadOptions) for an address that
  // isn't ours, is taken or needs --insecure.
  HttpServer(const HttpOptions& options, Dispatch dispatch);
  ~HttpServer();  // stops
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  int port() const;
  std::string url() const;  // "http://127.0.0.1:8080"

  // Answers, in threads of its own, from the return on.
  void Start();
  // Takes no more connections, finishes the requests at hand, and returns when all threads ended.
  void Stop();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace waystone
