// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

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
  int max_connections = 1024;
  int request_threads = 64;
  int backlog = 511;
  int keep_alive_s = 30;
  int head_timeout_s = 10;
  int read_timeout_s = 5;
  int body_timeout_s = 30;
  int write_timeout_s = 5;
  int answer_timeout_s = 60;
  int stop_timeout_s = 4;

  static constexpr auto Fields(const auto& use) {
    using Self = HttpOptions;
    return use(
        OptionField{"port", &Self::port, Closed(0, 65535), "",
                    "Port to listen on; 0 chooses any free one."},
        OptionField{"insecure", &Self::insecure, AnyValue(), "",
                    "Listen on an address that other machines can reach even though clients need "
                    "no token."},
        OptionField{"max_body_bytes", &Self::max_body_bytes, AtLeast(1), "bytes",
                    "Maximum size of a request body. A photo of 50 megapixels takes about 15 MB."},
        OptionField{"max_bodies_bytes", &Self::max_bodies_bytes, AtLeast(1), "bytes",
                    "Maximum total size of the bodies held at once, at least max_body_bytes; the "
                    "next request gets 429."},
        OptionField{"max_connections", &Self::max_connections, Closed(1, 100'000), "",
                    "Maximum number of open connections. For the next one, the connection that has "
                    "been idle longest is closed, or else the slowest one."},
        OptionField{"request_threads", &Self::request_threads, Closed(1, 10'000), "",
                    "Maximum number of requests that are being answered or waiting, each in a "
                    "thread. It should exceed the number of queries computed and waiting, or "
                    "nothing else is answered in the meantime."},
        OptionField{"backlog", &Self::backlog, AtLeast(1), "",
                    "Number of pending connections that the kernel queues; it refuses more."},
        OptionField{"keep_alive_s", &Self::keep_alive_s, AtLeast(1), "s",
                    "Time for which an idle connection is kept open."},
        OptionField{"head_timeout_s", &Self::head_timeout_s, AtLeast(1), "s",
                    "Time within which the request line and headers must arrive."},
        OptionField{"read_timeout_s", &Self::read_timeout_s, AtLeast(1), "s",
                    "Maximum time without receiving a byte of a body."},
        OptionField{"body_timeout_s", &Self::body_timeout_s, AtLeast(1), "s",
                    "Time within which a whole body must arrive. Longer times accept larger photos "
                    "over slow links."},
        OptionField{"write_timeout_s", &Self::write_timeout_s, AtLeast(1), "s",
                    "Maximum time for which the client accepts no bytes of an answer."},
        OptionField{"answer_timeout_s", &Self::answer_timeout_s, AtLeast(1), "s",
                    "Time within which the client must accept a whole answer."},
        OptionField{"stop_timeout_s", &Self::stop_timeout_s, AtLeast(1), "s",
                    "Time that answers in progress are given when the server stops."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// The HTTP/1.1 transport: sockets, limits and bodies. Knows nothing of maps. Refuses what could be
// read in two ways (bad, repeated or contradicting lengths, continued lines) and what could cost
// more than the limits say: long heads, encoded bodies and bodies over the limit. Ranges and
// compression are left undone. A client holds memory within bounds, never a thread. Requests that
// have arrived go to `dispatch`, from several threads at once; it must not throw. GET /healthz and
// /readyz don't wait behind others.
class HttpServer {
 public:
  using Dispatch = std::function<HttpResponse(const HttpRequest&)>;
  // Whether a body is worth reading, by the value of the header Authorization (empty without one);
  // `dispatch` is asked without one where it isn't. Thread-safe.
  using Admit = std::function<bool(const std::string& authorization)>;

  // Binds and listens, without answering yet. Throws MapError(kBadOptions) for an address that
  // isn't ours, is taken or needs --insecure, and where the limit of open files leaves little.
  HttpServer(const HttpOptions& options, Dispatch dispatch, Admit admit = nullptr);
  ~HttpServer();  // stops
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  int port() const;
  std::string url() const;  // "http://127.0.0.1:8080"

  // Answers, in threads of its own, from the return on.
  void Start();
  // From now on each answer closes its connection, so that clients go elsewhere.
  void Drain();
  // Takes no more connections, closes those whose request hasn't arrived completely, and finishes
  // the others; clients get options.stop_timeout_s to read their answers. `on_late` is called when
  // answers are still being computed then. Returns when all threads ended.
  void Stop(const std::function<void()>& on_late = nullptr);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace waystone
